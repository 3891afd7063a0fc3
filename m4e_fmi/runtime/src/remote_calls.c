/* The functions of FMI for an FMU in another process: each asks its server, remote_server.c. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "remote_client.h"

typedef struct {
    void (*functions[4])(void); /* logger, allocateMemory, freeMemory, stepFinished */
} callbacks_1;
typedef struct {
    void (*functions[4])(void);
    void *environment;
} callbacks_2;

static _Thread_local m4e_remote *next;

void m4e_remote_use(m4e_remote *r) { next = r; }

/* ---- begin and end ---- */

static m4e_given text(const char *s) {
    return (m4e_given){s ? s : "", s ? strlen(s) + 1 : 1};
}

static void *made(m4e_remote *r, uint32_t function, int version, void (*logger)(void),
                  void *environment, const char *name, const char *token, const char *resources) {
    m4e_listener *l = &r->listener;
    l->version = version;
    l->logger = logger;
    l->environment = environment;
    strncpy(l->name, name, sizeof l->name - 1);
    const m4e_given given[] = {text(name), text(token), text(resources)};
    const int status = m4e_remote_ask(r, function, given, COUNT(given), NULL, 0);
    return status || !r->channel->number[0] ? NULL : r;
}

M4E_API void *m4e_remote_fmiInstantiateSlave(const char *name, const char *guid,
                                             const char *location, const char *mime,
                                             double timeout, char visible, char interactive,
                                             callbacks_1 callbacks, char logging) {
    m4e_remote *r = next;
    m4e_channel *c = m4e_remote_begin(r);
    (void)mime, (void)interactive;
    c->real[0] = timeout;
    c->number[0] = (uint64_t)visible;
    c->number[1] = (uint64_t)logging;
    return made(r, M4E_fmiInstantiateSlave, 1, callbacks.functions[0], NULL, name, guid, location);
}

M4E_API void *m4e_remote_fmi2Instantiate(const char *name, int type, const char *guid,
                                         const char *resources, const callbacks_2 *callbacks,
                                         int visible, int logging) {
    m4e_remote *r = next;
    m4e_channel *c = m4e_remote_begin(r);
    c->number[0] = (uint64_t)type;
    c->number[1] = (uint64_t)visible;
    c->number[2] = (uint64_t)logging;
    return made(r, M4E_fmi2Instantiate, 2, callbacks->functions[0], callbacks->environment, name,
                guid, resources);
}

M4E_API void *m4e_remote_fmi3InstantiateCoSimulation(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool event_mode, bool early_return, const vr *required, size_t required_count,
    void *environment, void (*logger)(void), void (*update)(void)) {
    m4e_remote *r = next;
    m4e_channel *c = m4e_remote_begin(r);
    (void)required, (void)required_count, (void)update; /* none is used */
    c->number[0] = visible;
    c->number[1] = logging;
    c->number[2] = event_mode;
    c->number[3] = early_return;
    return made(r, M4E_fmi3InstantiateCoSimulation, 3, logger, environment, name, token, resources);
}

#define PLAIN(f, type)                                                                             \
    M4E_API int m4e_remote_##f(void *r) {                                                          \
        m4e_remote_begin(r);                                                                       \
        return m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                                       \
    }
#define FREE(f, type)                                                                              \
    M4E_API void m4e_remote_##f(void *r) {                                                         \
        m4e_remote_begin(r);                                                                       \
        m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                                              \
    }
#define INITIALIZE_1(f, type)                                                                      \
    M4E_API int m4e_remote_##f(void *r, double start, type stops, double stop) {                   \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        c->real[0] = start;                                                                        \
        c->real[1] = stop;                                                                         \
        c->number[0] = (uint64_t)stops;                                                            \
        return m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                                       \
    }
#define SETUP(f, type)                                                                             \
    M4E_API int m4e_remote_##f(void *r, type defined, double tolerance, double start, type stops,  \
                               double stop) {                                                      \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        c->number[0] = (uint64_t)defined;                                                          \
        c->number[1] = (uint64_t)stops;                                                            \
        c->real[0] = tolerance;                                                                    \
        c->real[1] = start;                                                                        \
        c->real[2] = stop;                                                                         \
        return m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                                       \
    }

/* ---- values ---- */

#define GET(f, type)                                                                               \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, type *values) {        \
        return m4e_remote_get(r, M4E_##f, references, count, count, values, sizeof(type));         \
    }
#define SET(f, type)                                                                               \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const type *values) {  \
        return m4e_remote_set(r, M4E_##f, references, count, count, values, sizeof(type));         \
    }
#define GET_SIZED(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, type *values,          \
                               size_t size) {                                                      \
        return m4e_remote_get(r, M4E_##f, references, count, size, values, sizeof(type));          \
    }
#define SET_SIZED(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const type *values,    \
                               size_t size) {                                                      \
        return m4e_remote_set(r, M4E_##f, references, count, size, values, sizeof(type));          \
    }

#define GET_TEXTS(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const type **values) { \
        return m4e_remote_get_texts(r, M4E_##f, references, count, values, count);                 \
    }
#define SET_TEXTS(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count,                        \
                               const type *const *values) {                                        \
        return m4e_remote_set_texts(r, M4E_##f, references, count, values, count);                 \
    }
#define GET_TEXTS_SIZED(f, type)                                                                   \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const type **values,   \
                               size_t size) {                                                      \
        return m4e_remote_get_texts(r, M4E_##f, references, count, values, size);                  \
    }
#define SET_TEXTS_SIZED(f, type)                                                                   \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count,                        \
                               const type *const *values, size_t size) {                           \
        return m4e_remote_set_texts(r, M4E_##f, references, count, values, size);                  \
    }

/* The answer: sizes (8 bytes each), then one content after the other. */
#define GET_BINARY(f, type)                                                                        \
    M4E_API int m4e_remote_##f(void *remote, const vr *references, size_t count, size_t *sizes,    \
                               const type **values, size_t size) {                                 \
        m4e_remote *r = remote;                                                                    \
        const int status = m4e_remote_get_now(r, M4E_##f, references, count, size, NULL, 0);       \
        const char *end, *at = status >= M4E_LOST ? NULL : m4e_remote_answer(r, &end);             \
        if (!at) return status < M4E_LOST ? M4E_LOST : status;                                     \
        if ((size_t)(end - at) < 8 * size) return M4E_LOST;                                        \
        const char *content = at + 8 * size;                                                       \
        for (size_t k = 0; k < size; ++k) {                                                        \
            uint64_t length;                                                                       \
            memcpy(&length, at + 8 * k, sizeof length);                                            \
            if (length > (size_t)(end - content)) return M4E_LOST;                                 \
            sizes[k] = (size_t)length;                                                             \
            values[k] = content;                                                                   \
            content += length;                                                                     \
        }                                                                                          \
        return status;                                                                             \
    }
#define SET_BINARY(f, type)                                                                        \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const size_t *sizes,   \
                               const type *const *values, size_t size) {                           \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        size_t total = 0;                                                                          \
        for (size_t k = 0; k < size; ++k) total += sizes[k];                                       \
        char *whole = malloc(8 * size + total + 1), *at = whole + 8 * size;                        \
        if (!whole) return M4E_LOST;                                                               \
        for (size_t k = 0; k < size; ++k) {                                                        \
            const uint64_t length = sizes[k];                                                      \
            memcpy(whole + 8 * k, &length, sizeof length);                                         \
            if (length) memcpy(at, values[k], sizes[k]);                                           \
            at += sizes[k];                                                                        \
        }                                                                                          \
        const m4e_given given[] = {{references, count * sizeof *references},                       \
                                   {whole, 8 * size + total}};                                     \
        c->number[0] = count;                                                                      \
        c->number[1] = size;                                                                       \
        const int status = m4e_remote_ask(r, M4E_##f, given, COUNT(given), NULL, 0);               \
        free(whole);                                                                               \
        return status;                                                                             \
    }

/* ---- derivatives ---- */

#define SET_ORDERS(f, type)                                                                        \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const int32_t *orders, \
                               const type *values) {                                               \
        return m4e_remote_with_orders(r, M4E_##f, references, count, orders, values, NULL, count); \
    }
#define GET_ORDERS(f, type)                                                                        \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const int32_t *orders, \
                               type *values) {                                                     \
        return m4e_remote_with_orders(r, M4E_##f, references, count, orders, NULL, values, count); \
    }
#define GET_ORDERS_SIZED(f, type)                                                                  \
    M4E_API int m4e_remote_##f(void *r, const vr *references, size_t count, const int32_t *orders, \
                               type *values, size_t size) {                                        \
        return m4e_remote_with_orders(r, M4E_##f, references, count, orders, NULL, values, size);  \
    }

#define DERIVATIVE(f, type)                                                                        \
    M4E_API int m4e_remote_##f(void *r, const vr *unknowns, size_t n, const vr *knowns, size_t m,  \
                               const type *seed, type *found) {                                    \
        return m4e_remote_derivative(r, M4E_##f, unknowns, n, knowns, m, seed, m, found, n);       \
    }
#define DERIVATIVE_SIZED(f, type)                                                                  \
    M4E_API int m4e_remote_##f(void *r, const vr *unknowns, size_t n, const vr *knowns, size_t m,  \
                               const type *seed, size_t seeds, type *found, size_t size) {         \
        return m4e_remote_derivative(r, M4E_##f, unknowns, n, knowns, m, seed, seeds, found, size);\
    }

/* ---- steps ---- */

#define BEGIN(name, f)                                                                             \
    M4E_API int m4e_remote_##name(void *r, double t, double h, int no_return) {                    \
        m4e_remote_begin_step(r, t, h, no_return, M4E_##f);                                        \
        return 0;                                                                                  \
    }
BEGIN(begin_1, fmiDoStep)
BEGIN(begin_2, fmi2DoStep)
BEGIN(begin_3, fmi3DoStep)

#define STEP(f, type)                                                                              \
    M4E_API int m4e_remote_##f(void *r, double t, double h, int no_return) {                       \
        return m4e_remote_step(r, M4E_##f, t, h, no_return);                                       \
    }
#define STEP_3(f, type)                                                                            \
    M4E_API int m4e_remote_##f(void *remote, double t, double h, bool no_return, bool *event,      \
                               bool *end, bool *early, double *reached) {                          \
        m4e_remote *r = remote;                                                                    \
        const m4e_channel *c = r->channel;                                                         \
        const int status = m4e_remote_step(r, M4E_##f, t, h, no_return);                           \
        if (status >= M4E_LOST) return status;                                                     \
        *event = c->number[1] & 1;                                                                 \
        *end = c->number[1] >> 1 & 1;                                                              \
        *early = c->number[1] >> 2 & 1;                                                            \
        if (c->number[2]) *reached = c->real[2];                                                   \
        return status;                                                                             \
    }
#define DISCRETE(f, type)                                                                          \
    M4E_API int m4e_remote_##f(void *r, bool *again, bool *end, bool *nominals, bool *values,      \
                               bool *defined, double *next_time) {                                 \
        bool *const flags[] = {again, end, nominals, values, defined};                             \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        c->number[0] = 0;                                                                          \
        for (int k = 0; k < COUNT(flags); ++k) c->number[0] |= (uint64_t)*flags[k] << k;           \
        c->real[0] = *next_time;                                                                   \
        const int status = m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                           \
        if (status >= M4E_LOST) return status;                                                     \
        for (int k = 0; k < COUNT(flags); ++k) *flags[k] = c->number[0] >> k & 1;                  \
        *next_time = c->real[0];                                                                   \
        return status;                                                                             \
    }
#define ANSWER(f, type)                                                                            \
    M4E_API int m4e_remote_##f(void *r, int kind, type *value) {                                   \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        c->number[0] = (uint64_t)kind;                                                             \
        c->real[0] = (double)*value;                                                               \
        const int status = m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                           \
        if (status < M4E_LOST) *value = (type)c->real[0];                                          \
        return status;                                                                             \
    }

/* ---- states: the worker's addresses, as they are ---- */

#define GET_STATE(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, void **state) {                                            \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        c->number[0] = (uint64_t)(uintptr_t)*state;                                                \
        const int status = m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                           \
        if (status < M4E_LOST) *state = (void *)(uintptr_t)c->number[0];                           \
        return status;                                                                             \
    }
#define SET_STATE(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, void *state) {                                             \
        m4e_remote_begin(r)->number[0] = (uint64_t)(uintptr_t)state;                               \
        return m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                                       \
    }
#define STATE_SIZE(f, type)                                                                        \
    M4E_API int m4e_remote_##f(void *r, void *state, size_t *size) {                               \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        c->number[0] = (uint64_t)(uintptr_t)state;                                                 \
        const int status = m4e_remote_ask(r, M4E_##f, NULL, 0, NULL, 0);                           \
        if (status < M4E_LOST) *size = (size_t)c->number[1];                                       \
        return status;                                                                             \
    }
#define SERIALIZE(f, type)                                                                         \
    M4E_API int m4e_remote_##f(void *r, void *state, type *bytes, size_t size) {                   \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        const m4e_wanted wanted[] = {{bytes, size}};                                               \
        c->number[0] = (uint64_t)(uintptr_t)state;                                                 \
        c->number[1] = size;                                                                       \
        return m4e_remote_ask(r, M4E_##f, NULL, 0, wanted, COUNT(wanted));                         \
    }
#define DESERIALIZE(f, type)                                                                       \
    M4E_API int m4e_remote_##f(void *r, const type *bytes, size_t size, void **state) {            \
        m4e_channel *c = m4e_remote_begin(r);                                                      \
        const m4e_given given[] = {{bytes, size}};                                                 \
        c->number[0] = (uint64_t)(uintptr_t)*state;                                                \
        c->number[1] = size;                                                                       \
        const int status = m4e_remote_ask(r, M4E_##f, given, COUNT(given), NULL, 0);               \
        if (status < M4E_LOST) *state = (void *)(uintptr_t)c->number[0];                           \
        return status;                                                                             \
    }

#define INSTANTIATE_1(f, type)
#define INSTANTIATE_2(f, type)
#define INSTANTIATE_3(f, type)
#define DEFINE(name, shape, type) shape(name, type)
M4E_REMOTE_FUNCTIONS(DEFINE)
