/* Performs calls of FMI on an FMU of this process, as they are asked for by remote_client.c. */
#ifndef _WIN32
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "environment.h"
#include "remote.h"

typedef void (*any)(void);
enum { WARNING = 1, ERROR = 3, PENDING = 5 };

/* The only FMU of this process. */
static struct {
    m4e_end end;
    long process; /* that began to serve */
    void *component;
    void *pointers; /* arrays of them for the present call */
} serving;
static _Thread_local bool is_serving; /* this thread, during a call */

/* ---- messages ---- */

/* A process that an FMU has forked, and that returns from its call, too, serves nobody. */
static void end_if_forked(void) {
    if (getpid() != serving.process) _exit(0);
}

/* To the client, if it waits for a call; otherwise to standard error. */
static void log_1(void *environment, const char *name, int status, const char *category,
                  const char *format, ...) {
    static _Thread_local m4e_message message;
    va_list arguments;
    (void)environment, (void)name, (void)category;
    va_start(arguments, format);
    if (vsnprintf(message.text, sizeof message.text, format ? format : "", arguments) < 0)
        message.text[0] = 0;
    va_end(arguments);
    if (!is_serving) {
        fprintf(stderr, "%s\n", message.text);
        return;
    }
    end_if_forked();
    message.status = status;
    const size_t size = offsetof(m4e_message, text) + strlen(message.text) + 1;
    m4e_send(&serving.end, M4E_MESSAGE, &message, size);
    if (m4e_await_parcel(&serving.end) != M4E_GO_ON) exit(1); /* the client is gone */
}

static void log_3(void *environment, int status, const char *category, const char *text) {
    log_1(environment, "", status, category, "%s", text ? text : "");
}

static callbacks_2 callbacks = {{{(any)log_1, (any)calloc, (any)free, NULL}}, &serving};

/* ---- arguments, from the request and to the answer ---- */

static void *pointers(size_t count) {
    return serving.pointers = calloc(count + 1, sizeof(void *));
}

static const void *taken_all(m4e_bytes *in, size_t count, size_t size) {
    if (size) return m4e_take(in, count * size);
    m4e_text *texts = pointers(count);
    for (size_t k = 0; k < count && texts; ++k) texts[k] = m4e_take_text(in);
    return texts;
}

static void *room_for(m4e_bytes *out, size_t count, size_t size) {
    if (!size) return pointers(count);
    void *room = m4e_extend(out, count * size);
    if (room) memset(room, 0, count * size);
    return room;
}

/* What the FMU has put into `room_for` it: texts are still to be copied. */
static void give_all(m4e_bytes *out, const void *values, size_t count, size_t size, int status) {
    m4e_text const *text = values;
    for (size_t k = 0; k < count && !size; ++k) {
        const char *found = text[k] && status <= WARNING ? text[k] : "";
        m4e_put_blob(out, found, strlen(found) + 1);
    }
}

static int made(void *component) {
    const uint64_t is_made = component != NULL;
    serving.component = component;
    m4e_put(&serving.end.out, &is_made, sizeof is_made);
    return 0;
}

#define TAKE(kind, ...) TAKE_##kind(__VA_ARGS__)
#define TAKE_VALUE(T, name) const T name = *(const T *)m4e_take(in, sizeof(T));
#define TAKE_CHANGED(T, name) T *const name = m4e_take(in, sizeof(T));
#define TAKE_GIVEN(T, name, count) const T *const name = taken_all(in, count, SIZE_OF(T));         \
    if (!name) return ERROR;
#define TAKE_WANTED(T, name, count) T *const name = room_for(out, count, SIZE_OF(T));              \
    if (!name) return ERROR;
#define TAKE_COUNT(name) TAKE_VALUE(size_t, name##_count)
#define TAKE_ARRAY(T, name) TAKE_COUNT(name) TAKE_GIVEN(T, name, name##_count)
#define TAKE_ROOM(T, name) TAKE_COUNT(name) TAKE_WANTED(T, name, name##_count)
#define TAKE_TEXT(name) const char *const name = m4e_take_text(in);
#define TAKE_CALLBACKS_1(name)
#define TAKE_CALLBACKS_2(name)
#define TAKE_CALLBACKS_3(name)

#define PASS(kind, ...) PASS_##kind(__VA_ARGS__)
#define PASS_VALUE(T, name) , name
#define PASS_CHANGED(T, name) , name
#define PASS_GIVEN(T, name, count) , name
#define PASS_WANTED(T, name, count) , name
#define PASS_ARRAY(T, name) , name, name##_count
#define PASS_ROOM(T, name) , name, name##_count
#define PASS_TEXT(name) , name
#define PASS_CALLBACKS_1(name) , callbacks.callbacks
#define PASS_CALLBACKS_2(name) , &callbacks
#define PASS_CALLBACKS_3(name) , &serving, (any)log_3, NULL

#define GIVE(kind, ...) GIVE_##kind(__VA_ARGS__)
#define GIVE_VALUE(T, name)
#define GIVE_CHANGED(T, name) m4e_put(out, name, sizeof(T));
#define GIVE_GIVEN(T, name, count)
#define GIVE_WANTED(T, name, count) give_all(out, name, count, SIZE_OF(T), status);
#define GIVE_ARRAY(T, name)
#define GIVE_ROOM(T, name) GIVE_WANTED(T, name, name##_count)
#define GIVE_TEXT(name)
#define GIVE_CALLBACKS_1(name)
#define GIVE_CALLBACKS_2(name)
#define GIVE_CALLBACKS_3(name)

/* ---- calls ---- */

#define CALL(signature, T)                                                                         \
    ((int (*)(void *signature(PARAMETER, T)))f)(serving.component signature(PASS, T))
#define CALL_NOW CALL
#define CALL_LATE CALL
#define CALL_AHEAD CALL
#define CALL_STEP CALL
#define CALL_FREE(signature, T) (((void (*)(void *))f)(serving.component), made(NULL))
#define CALL_MAKE(signature, T)                                                                    \
    made(((void *(*)(WITHOUT_FIRST(signature(PARAMETER, T))))f)(WITHOUT_FIRST(signature(PASS, T))))
#define DEFINE(name, how, signature, T)                                                            \
    static int call_##name(any f, m4e_bytes *in, m4e_bytes *out) {                                 \
        (void)in, (void)out;                                                                       \
        signature(TAKE, T)                                                                         \
        const int status = CALL_##how(signature, T);                                               \
        signature(GIVE, T)                                                                         \
        return status;                                                                             \
    }
M4E_REMOTE_FUNCTIONS(DEFINE)

enum { HOW_NOW, HOW_LATE, HOW_AHEAD, HOW_STEP, HOW_MAKE, HOW_FREE };
#define ENTRY(name, how, signature, T) {call_##name, HOW_##how},
static const struct {
    int (*call)(any f, m4e_bytes *in, m4e_bytes *out);
    int how;
} CALLS[] = {M4E_REMOTE_FUNCTIONS(ENTRY)};

static int called(any f, uint32_t function) {
    atomic_store(&serving.end.channel->present, function);
    const int status = f ? CALLS[function].call(f, &serving.end.in, &serving.end.out) : ERROR;
    free(serving.pointers);
    serving.pointers = NULL;
    end_if_forked();
    m4e_default_environment();
    return status < 0 || status > PENDING ? M4E_NO_STATUS : status;
}

/* A step of FMI 3.0 has ended with an event or early, or is the last. */
static bool has_event(const m4e_bytes *out, size_t place) {
    bool found = false;
    for (int k = 0; k < 3 && place < out->size; ++k, place += 8) found |= out->at[place];
    return found;
}

/* Performs the calls of a request, up to one that fails. */
static m4e_answer performed(any const *functions) {
    m4e_channel *c = serving.end.channel;
    m4e_bytes *in = &serving.end.in, *out = &serving.end.out;
    m4e_answer answer = {0, -1, 0};
    bool has_stepped = false;
    while (in->place < in->size && answer.status <= WARNING) {
        const uint32_t function = *(const uint32_t *)m4e_take(in, sizeof function);
        const int how = CALLS[function].how;
        const size_t place = out->size;
        const int status = called(functions[function], function);
        if (has_stepped) {
            answer.ahead_status = status;
            answer.ahead = place;
            break;
        }
        if (how != HOW_LATE || status > answer.status) answer.status = status;
        if (how == HOW_LATE && status > WARNING) {
            c->late_function = function;
            c->late_status = status;
            answer.status = M4E_LATE;
        }
        has_stepped = how == HOW_STEP;
        if (has_stepped && has_event(out, place)) break;
    }
    return answer;
}

static void begin_answer(void) {
    serving.end.out.size = 0;
    m4e_extend(&serving.end.out, sizeof(m4e_answer));
}

static void answer(m4e_answer head) {
    m4e_bytes *out = &serving.end.out;
    memcpy(out->at, &head, sizeof head);
    atomic_store(&serving.end.channel->busy, 0);
    m4e_send(&serving.end, M4E_ANSWER, out->at, out->size);
}

static void begin(m4e_channel *channel) {
    serving.end = (m4e_end){.channel = channel, .side = M4E_SERVER};
    serving.process = getpid();
    begin_answer();
}

void m4e_remote_refuse(m4e_channel *channel, const char *why) {
    begin(channel);
    m4e_put(&serving.end.out, why, strlen(why) + 1);
    answer((m4e_answer){ERROR, -1, 0});
}

int m4e_remote_serve(m4e_channel *channel, void (*const *functions)(void)) {
    uint32_t kind;
    m4e_default_environment(); /* loading an FMU may have changed it */
    begin(channel);
    answer((m4e_answer){0, -1, 0});
    while ((kind = m4e_hear(&serving.end)) == M4E_REQUEST) {
        begin_answer();
        is_serving = true;
        const m4e_answer head = performed(functions);
        is_serving = false;
        answer(head);
    }
    atomic_store(&channel->present, M4E_END);
    return kind != M4E_LEAVE;
}
#endif
