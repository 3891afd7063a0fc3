/* Performs calls of FMI on an FMU of this process, as they are asked for by remote_calls.c. */
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "environment.h"
#include "remote_server.h"
#ifndef _WIN32
#include <unistd.h>
#endif

typedef void (*any)(void);
enum { CLIENT, SERVER };
enum { WARNING = M4E_REMOTE_WARNING, ERROR = M4E_REMOTE_ERROR, PENDING = 5 };

m4e_remote_server m4e_serving;
static _Thread_local bool is_serving; /* this thread, during a call */

/* ---- channel ---- */

static int hear(void) {
    m4e_channel *c = m4e_serving.channel;
    if (!m4e_remote_wait(&c->asked, m4e_serving.seen, &c->asleep[SERVER], &c->lost,
                         &m4e_serving.eager))
        return 0;
    m4e_serving.seen = atomic_load(&c->asked);
    return 1;
}

/* A process that an FMU has forked, and that returns from its call, too, serves nobody. */
static void end_if_forked(void) {
#ifndef _WIN32
    if (getpid() != m4e_serving.process) _exit(0);
#endif
}

static void answer(int status, int is_message) {
    m4e_channel *c = m4e_serving.channel;
    c->status = status;
    c->is_message = is_message;
    atomic_fetch_add(&c->answered, 1);
    m4e_remote_wake(&c->answered, &c->asleep[CLIENT]);
}

/* To the client, if it waits for a call; otherwise to standard error. */
static void tell(int status, const char *text) {
    m4e_channel *c = m4e_serving.channel;
    if (!is_serving) {
        fprintf(stderr, "%s\n", text);
        return;
    }
    end_if_forked();
    strncpy(c->text, text, M4E_TEXT_ROOM - 1);
    answer(status, 1);
    if (!hear()) exit(1); /* the client is gone */
}

void m4e_remote_log(void *environment, const char *name, int status, const char *category,
                    const char *message, ...) {
    static _Thread_local char text[M4E_TEXT_ROOM];
    va_list arguments;
    (void)environment, (void)name, (void)category;
    va_start(arguments, message);
    if (vsnprintf(text, sizeof text, message ? message : "", arguments) < 0) text[0] = 0;
    va_end(arguments);
    tell(status, text);
}

void m4e_remote_log_3(void *environment, int status, const char *category, const char *text) {
    (void)environment, (void)category;
    tell(status, text ? text : "");
}

/* ---- requests ---- */

/* A piece of a request that does not fit. */
static int collect(void) {
    m4e_channel *c = m4e_serving.channel;
    if (!c->taken) {
        free(m4e_serving.request);
        m4e_serving.request = calloc(1, c->given);
    }
    if (!m4e_serving.request) return ERROR;
    const size_t rest = c->given - c->taken;
    memcpy(m4e_serving.request + c->taken, c->request, rest < M4E_ROOM ? rest : M4E_ROOM);
    return 0;
}

static int called(any f, uint32_t function, const uint64_t *number, const unsigned char *at) {
    for (int k = 0; k < 4; ++k) m4e_serving.number[k] = number[k];
    m4e_serving.at = at;
    atomic_store(&m4e_serving.channel->present, function);
    const m4e_remote_shape *shape = &M4E_REMOTE_SHAPES[function];
    const int status = f ? shape->perform(f, shape->size) : ERROR;
    end_if_forked();
    m4e_default_environment();
    return status < 0 || status > PENDING ? M4E_NO_STATUS : status;
}

/* Sets the values that have come along. The status: OK, WARNING, or M4E_LATE if a call fails. */
static int set_late(any const *functions) {
    m4e_channel *c = m4e_serving.channel;
    const unsigned char *at = c->request, *end = at + c->late;
    int worst = 0;
    while (at < end) {
        m4e_late head;
        memcpy(&head, at, sizeof head);
        const uint64_t number[4] = {head.number[0], head.number[1]};
        at += sizeof head;
        const int status = called(functions[head.function], head.function, number, at);
        if (status > WARNING) {
            c->late_function = head.function;
            c->late_status = status;
            return M4E_LATE;
        }
        if (status == WARNING) worst = WARNING;
        at += head.size;
    }
    return worst;
}

/* Reads what is expected to be wanted after a step. */
static void read_ahead(any const *functions, const unsigned char *references) {
    m4e_channel *c = m4e_serving.channel;
    const uint64_t number[4] = {c->ahead_counts[0], c->ahead_counts[1]};
    c->ahead_status = called(functions[c->ahead], c->ahead, number, references);
}

static void perform(any const *functions, uint32_t function) {
    m4e_channel *c = m4e_serving.channel;
    const unsigned char *at = m4e_serving.request ? m4e_serving.request : c->request + c->late;
    is_serving = true;
    c->ahead_status = -1;
    int status = set_late(functions);
    if (status != M4E_LATE && function != M4E_SETS) {
        status = called(functions[function], function, c->number, at);
        if (m4e_remote_is_step(function) && status <= WARNING && c->ahead != M4E_LOAD)
            read_ahead(functions, at);
    }
    is_serving = false;
    free(m4e_serving.request);
    m4e_serving.request = NULL;
    atomic_store(&c->busy, 0);
    answer(status, 0);
}

void m4e_remote_refuse(m4e_channel *c, const char *why) {
    m4e_serving.channel = c;
    strncpy(c->text, why, M4E_TEXT_ROOM - 1);
    atomic_store(&c->busy, 0);
    answer(ERROR, 0);
}

int m4e_remote_serve(m4e_channel *c, void (*const *functions)(void)) {
    m4e_serving.channel = c;
#ifndef _WIN32
    m4e_serving.process = getpid();
#endif
    m4e_default_environment(); /* loading an FMU may have changed it */
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
            memcpy(c->answer, m4e_serving.answer + c->given, c->taken);
            answer(0, 0);
        } else {
            perform(functions, function);
        }
    }
    return 1;
}
