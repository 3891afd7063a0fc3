/* The functions of FMI for an FMU in another process, for a master. */
#ifndef _WIN32
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "remote.h"

enum { WARNING = 1, SURE = 2 /* steps after which it is known what is read */ };
enum { LATE_ROOM = 1 << 15 /* bytes of values that wait */ };

/* One instance of an FMU in a worker, which is its component. */
typedef struct {
    m4e_end end;
    size_t call; /* the present call's place in the request */
    int stepping; /* a step is asked for, and not awaited yet: `step` are its function and times */
    unsigned char step[32];
    int has_stepped; /* the last call was a step */
    m4e_bytes ahead; /* the call that is expected after steps */
    int seen;        /* how many steps were followed by it, one after the other */
    int ready;       /* what it brings has come with the last step */
    int version; /* of FMI; who receives the FMU's messages: */
    void (*logger)(void);
    void *environment;
    char name[256];
} m4e_remote;

typedef void logger_1(void *component, const char *name, int status, const char *category,
                      const char *format, ...);
typedef void logger_3(void *environment, int status, const char *category, const char *text);

static _Thread_local m4e_remote *next;

/* ---- what a master does beside calls ---- */

M4E_API size_t m4e_remote_size(void) { return sizeof(m4e_channel); }

/* Of all functions, with spaces. */
#define NAME(name, how, signature, T) #name " "
M4E_API const char *m4e_remote_names(void) { return M4E_REMOTE_FUNCTIONS(NAME); }

M4E_API m4e_remote *m4e_remote_new(m4e_channel *channel) { /* NULL: no memory */
    m4e_remote *r = calloc(1, sizeof *r);
    if (r) r->end.channel = channel;
    return r;
}

M4E_API void m4e_remote_free(m4e_remote *r) {
    free(r->end.in.at);
    free(r->end.out.at);
    free(r->ahead.at);
    free(r);
}

/* The next instance of this thread is there. */
M4E_API void m4e_remote_use(m4e_remote *r) { next = r; }

/* The worker is gone: ends all waiting. */
M4E_API void m4e_remote_give_up(m4e_channel *c) {
    atomic_store(&c->lost, 1);
    m4e_wake(&c->way[M4E_CLIENT]);
}

/* Has the server return, and waits for nothing; 1: it cannot, in a step that is not awaited. */
M4E_API int m4e_remote_end(m4e_remote *r) {
    if (!r->stepping) m4e_send(&r->end, M4E_LEAVE, NULL, 0);
    return r->stepping;
}

/* The text of the last answer. */
M4E_API const char *m4e_remote_text(const m4e_remote *r) {
    return r->end.in.at ? (const char *)r->end.in.at + r->end.in.place : "";
}

/* ---- requests ---- */

static void pass_on(const m4e_remote *r) {
    m4e_bytes in = r->end.in;
    const int64_t *status = m4e_take(&in, sizeof *status);
    const char *text = (const char *)in.at + in.place;
    if (!status || !r->logger) return;
    if (r->version == 3)
        ((logger_3 *)r->logger)(r->environment, (int)*status, "", text);
    else
        ((logger_1 *)r->logger)(r->environment, r->name, (int)*status, "", "%s", text);
}

/* The answer's status, also to a request of another function. */
M4E_API int m4e_remote_await(m4e_remote *r) {
    uint32_t kind;
    r->stepping = 0;
    while ((kind = m4e_hear(&r->end)) == M4E_MESSAGE) {
        pass_on(r);
        m4e_send(&r->end, M4E_GO_ON, NULL, 0);
    }
    const m4e_answer *answer = kind == M4E_ANSWER ? m4e_take(&r->end.in, sizeof *answer) : NULL;
    return answer ? answer->status : M4E_LOST;
}

/* Sends the calls that wait; a step that was begun and not awaited has been made before. */
static void post(m4e_remote *r) {
    m4e_channel *c = r->end.channel;
    if (!atomic_load(&c->lost)) {
        atomic_fetch_add(&c->calls, 1);
        atomic_store(&c->busy, 1);
        m4e_send(&r->end, M4E_REQUEST, r->end.out.at, r->end.out.size);
    }
    r->end.out.size = 0;
}

/* Before a call that is not the step which goes on: awaits that, and forgets what it has read. */
static void settle(m4e_remote *r) {
    if (r->stepping) m4e_remote_await(r);
    if (r->has_stepped) r->seen = 0;
    r->has_stepped = r->ready = 0;
}

static int ask(m4e_remote *r) {
    settle(r);
    post(r);
    return m4e_remote_await(r);
}

/* Sets values now that wait; M4E_LATE, M4E_LOST, 0, 1. */
M4E_API int m4e_remote_flush(m4e_remote *r) {
    settle(r);
    return r->end.out.size ? ask(r) : 0;
}

static int put_off(m4e_remote *r) {
    settle(r);
    return r->end.out.size > LATE_ROOM ? ask(r) : 0;
}

/* Values may have come with the last step. */
static int read_values(m4e_remote *r) {
    m4e_bytes *out = &r->end.out;
    const unsigned char *call = out->at + r->call;
    const size_t size = out->size - r->call;
    if (!r->has_stepped) return ask(r);
    r->has_stepped = 0;
    const int same = r->ahead.size == size && !memcmp(r->ahead.at, call, size);
    r->seen = same ? r->seen + (r->seen < SURE) : 1;
    if (!same) {
        r->ahead.size = 0;
        m4e_put(&r->ahead, call, size);
    } else if (r->ready) {
        const m4e_answer *answer = (const m4e_answer *)r->end.in.at;
        r->ready = 0;
        r->end.in.place = answer->ahead;
        out->size = r->call;
        return answer->ahead_status;
    }
    return ask(r);
}

static void begin_step(m4e_remote *r) {
    m4e_bytes *out = &r->end.out;
    const unsigned char *call = out->at + r->call;
    if (r->stepping && !memcmp(r->step, call, sizeof r->step)) {
        out->size = r->call;
        return;
    }
    settle(r);
    memcpy(r->step, call, sizeof r->step);
    if (r->seen >= SURE) m4e_put(out, r->ahead.at, r->ahead.size);
    post(r);
    r->stepping = 1;
}

static int step(m4e_remote *r) {
    begin_step(r);
    const int status = m4e_remote_await(r);
    const m4e_answer *answer = (const m4e_answer *)r->end.in.at;
    r->has_stepped = 1;
    r->ready = r->seen >= SURE && status <= WARNING && answer->ahead_status >= 0;
    return status;
}

/* ---- functions ---- */

static m4e_remote *opened(void *remote, uint32_t function) {
    m4e_remote *r = remote;
    r->call = r->end.out.size;
    m4e_put(&r->end.out, &function, sizeof function);
    return r;
}

static void listen(m4e_remote *r, int version, const char *name, void (*logger)(void),
                   void *environment) {
    r->version = version;
    r->logger = logger;
    r->environment = environment;
    strncpy(r->name, name, sizeof r->name - 1);
}

static void take_all(m4e_bytes *from, void *values, size_t count, size_t size) {
    m4e_text *text = values;
    const void *at = size ? m4e_take(from, count * size) : NULL;
    if (at && count) memcpy(values, at, count * size);
    for (size_t k = 0; k < count && !size; ++k) text[k] = m4e_take_text(from);
}

static int completed(const m4e_remote *r, int status) {
    return r->end.in.failed || r->end.out.failed ? M4E_LOST : status;
}

#define SEND(kind, ...) SEND_##kind(__VA_ARGS__)
#define SEND_VALUE(T, name) m4e_put(out, &name, sizeof name);
#define SEND_CHANGED(T, name) m4e_put(out, name, sizeof *name);
#define SEND_GIVEN(T, name, count) m4e_put_all(out, name, count, SIZE_OF(T));
#define SEND_WANTED(T, name, count)
#define SEND_ARRAY(T, name) SEND_ROOM(T, name) SEND_GIVEN(T, name, name##_count)
#define SEND_ROOM(T, name) m4e_put(out, &name##_count, sizeof name##_count);
#define SEND_TEXT(name) m4e_put_all(out, &name, 1, 0);
#define SEND_CALLBACKS_1(callbacks) listen(r, 1, name, callbacks.functions[0], NULL);
#define SEND_CALLBACKS_2(given)                                                                    \
    listen(r, 2, name, given->callbacks.functions[0], given->environment);
#define SEND_CALLBACKS_3(logger) (void)update, listen(r, 3, name, logger, environment);

#define RECEIVE(kind, ...) RECEIVE_##kind(__VA_ARGS__)
#define RECEIVE_VALUE(T, name)
#define RECEIVE_CHANGED(T, name) take_all(in, name, 1, sizeof *name);
#define RECEIVE_GIVEN(T, name, count)
#define RECEIVE_WANTED(T, name, count) take_all(in, name, count, SIZE_OF(T));
#define RECEIVE_ARRAY(T, name)
#define RECEIVE_ROOM(T, name) RECEIVE_WANTED(T, name, name##_count)

#define CALL(name, asked, signature, T)                                                            \
    M4E_API int m4e_remote_##name(void *remote signature(PARAMETER, T)) {                          \
        m4e_remote *r = opened(remote, M4E_##name);                                                \
        m4e_bytes *out = &r->end.out, *in = &r->end.in;                                            \
        signature(SEND, T)                                                                         \
        const int status = asked(r);                                                               \
        (void)out, (void)in;                                                                       \
        if (status < M4E_LOST) { signature(RECEIVE, T) }                                           \
        return completed(r, status);                                                               \
    }
#define CALL_NOW(name, signature, T) CALL(name, ask, signature, T)
#define CALL_LATE(name, signature, T) CALL(name, put_off, signature, T)
#define CALL_AHEAD(name, signature, T) CALL(name, read_values, signature, T)
#define CALL_STEP(name, signature, T) CALL(name, step, signature, T)
#define CALL_FREE(name, signature, T)                                                              \
    M4E_API void m4e_remote_##name(void *remote) { ask(opened(remote, M4E_##name)); }
#define CALL_MAKE(f, signature, T)                                                                 \
    M4E_API void *m4e_remote_##f(WITHOUT_FIRST(signature(PARAMETER, T))) {                         \
        m4e_remote *r = opened(next, M4E_##f);                                                     \
        m4e_bytes *out = &r->end.out;                                                              \
        signature(SEND, T)                                                                         \
        const int status = ask(r);                                                                 \
        const uint64_t *made = status ? NULL : m4e_take(&r->end.in, sizeof *made);                 \
        return made && *made ? r : NULL;                                                           \
    }
#define DEFINE(name, how, signature, T) CALL_##how(name, signature, T)
M4E_REMOTE_FUNCTIONS(DEFINE)

/* Ask for a step, which the call of DoStep with the same arguments then awaits. */
#define BEGIN(number, name, signature, T)                                                          \
    M4E_API int m4e_remote_begin_##number(void *remote, double t, double h, int given) {           \
        m4e_remote *r = opened(remote, M4E_##name);                                                \
        m4e_bytes *out = &r->end.out;                                                              \
        const T no_return = (T)given, none = 0, *event = &none, *end = &none, *early = &none;      \
        const double stop = t + h, *reached = &stop;                                               \
        (void)event, (void)end, (void)early, (void)reached;                                        \
        signature(SEND, T)                                                                         \
        begin_step(r);                                                                             \
        return 0;                                                                                  \
    }
BEGIN(1, fmiDoStep, STEP, char)
BEGIN(2, fmi2DoStep, STEP, int)
BEGIN(3, fmi3DoStep, STEP_3, bool)
#endif
