/* Calls of an FMU by a client and a server in two threads: every kind of argument there and back,
   small and in parts, values that are set late, steps with what is read after them. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "remote.h"

enum { LARGE = 100000, ENOUGH = LARGE + 1 };
#define EXPECT(condition)                                                                          \
    do {                                                                                           \
        if (condition) break;                                                                      \
        printf("line %d: %s\n", __LINE__, #condition);                                             \
        exit(1);                                                                                   \
    } while (0)
#define CLIENT(name, how, signature, T) CLIENT_##how(name, signature, T)
#define CLIENT_NOW(name, signature, T) int m4e_remote_##name(void *remote signature(PARAMETER, T));
#define CLIENT_LATE CLIENT_NOW
#define CLIENT_AHEAD CLIENT_NOW
#define CLIENT_STEP CLIENT_NOW
#define CLIENT_FREE(name, signature, T) void m4e_remote_##name(void *remote);
#define CLIENT_MAKE(name, signature, T)                                                            \
    void *m4e_remote_##name(WITHOUT_FIRST(signature(PARAMETER, T)));
M4E_REMOTE_FUNCTIONS(CLIENT)
void *m4e_remote_new(m4e_channel *channel);
void m4e_remote_free(void *remote);
void m4e_remote_use(void *remote);
int m4e_remote_await(void *remote), m4e_remote_flush(void *remote), m4e_remote_end(void *remote);
int m4e_remote_begin_3(void *remote, double t, double h, int no_return);

/* ---- the FMU: keeps what is set ---- */

static double numbers[ENOUGH];
static const char *texts[3];
static int reads, refuses, messages;
static void (*log_message)(void *, int, const char *, const char *);

static int get(void *c, const uint32_t r[], size_t n, double values[], size_t room) {
    for (size_t k = 0; k < room; ++k) values[k] = numbers[r[k]];
    return ++reads && n == room && c == numbers ? 0 : 3;
}
static int set(void *c, const uint32_t r[], size_t n, const double values[], size_t given) {
    for (size_t k = 0; k < given; ++k) numbers[r[k]] = values[k];
    return refuses ? 3 : n == given && c == numbers ? 0 : 3;
}
static int get_texts(void *c, const uint32_t r[], size_t n, const char *values[], size_t room) {
    (void)c, (void)n;
    for (size_t k = 0; k < room; ++k) values[k] = texts[r[k]];
    return 0;
}
static int set_texts(void *c, const uint32_t r[], size_t n, const char *const values[], size_t m) {
    (void)c, (void)n;
    for (size_t k = 0; k < m; ++k) texts[r[k]] = strcpy(malloc(strlen(values[k]) + 1), values[k]);
    return 0;
}
static int step(void *c, double t, double h, bool no_return, bool *event, bool *end, bool *early,
                double *reached) {
    (void)c, (void)no_return, (void)end, (void)early;
    *event = t >= 10.0;
    *reached = t + h;
    log_message(NULL, 1, "", "a step");
    return 0;
}
static int derivative(void *c, const uint32_t y[], size_t n, const uint32_t x[], size_t m,
                      const double seed[], size_t seeds, double found[], size_t size) {
    (void)c;
    for (size_t k = 0; k < size; ++k) found[k] = y[k] + x[0] * seed[0];
    return n == size && m == seeds ? 0 : 3;
}
static int get_state(void *c, void **state) {
    *state = *state ? *state : c;
    return 0;
}
static int state_size(void *c, void *state, size_t *size) {
    *size = state == c ? LARGE : 0;
    return 0;
}
static int serialize(void *c, void *state, unsigned char bytes[], size_t size) {
    memset(bytes, 7, size);
    return c == state ? 0 : 3;
}
static void free_nothing(void *c) { EXPECT(c == numbers); }
static void *made(const char *name, const char *token, const char *place, bool visible, bool logging,
                  bool events, bool early, const uint32_t required[], size_t count, void *e,
                  void (*logger)(void), void (*update)(void)) {
    (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)e, (void)update;
    log_message = (void (*)(void *, int, const char *, const char *))logger;
    return strcmp(name, "n") || strcmp(token, "t") || place || count ? NULL : numbers;
}

static void *serve(void *channel) {
    static void (*functions[M4E_LOAD])(void);
#define PUT(name, function) functions[M4E_##name] = (void (*)(void))function;
    PUT(fmi3InstantiateCoSimulation, made) PUT(fmi3GetFloat64, get) PUT(fmi3SetFloat64, set)
    PUT(fmi3GetString, get_texts) PUT(fmi3SetString, set_texts)
    PUT(fmi3DoStep, step) PUT(fmi3GetFMUState, get_state)
    PUT(fmi3SerializedFMUStateSize, state_size) PUT(fmi3SerializeFMUState, serialize)
    PUT(fmi3GetDirectionalDerivative, derivative) PUT(fmi3FreeInstance, free_nothing)
    return m4e_remote_serve(channel, functions) ? channel : NULL;
}

static void hear(void *environment, int status, const char *category, const char *text) {
    (void)environment, (void)category;
    messages += status == 1 && strcmp(text, "a step") == 0;
}

int main(void) {
    static m4e_channel channel;
    static uint32_t all[ENOUGH];
    static double given[ENOUGH], found[ENOUGH];
    pthread_t server;
    void *r = m4e_remote_new(&channel);
    pthread_create(&server, NULL, serve, &channel);
    EXPECT(m4e_remote_await(r) == 0);
    m4e_remote_use(r);
    r = m4e_remote_fmi3InstantiateCoSimulation("n", "t", NULL, 0, 0, 0, 0, NULL, 0, NULL,
                                               (void (*)(void))hear, NULL);
    EXPECT(r);
    for (size_t k = 0; k < LARGE; ++k) given[all[k] = (uint32_t)k] = (double)k;
    EXPECT(!m4e_remote_fmi3SetFloat64(r, all, LARGE, given, LARGE));
    EXPECT(!m4e_remote_fmi3GetFloat64(r, all, LARGE, found, LARGE));
    EXPECT(!memcmp(given, found, sizeof given));

    const double late = -1.0;
    EXPECT(!m4e_remote_fmi3SetFloat64(r, all + 2, 1, &late, 1) && numbers[2] == 2.0);
    EXPECT(m4e_remote_flush(r) == 0 && numbers[2] == late);
    refuses = 1;
    EXPECT(!m4e_remote_fmi3SetFloat64(r, all, 1, &late, 1));
    EXPECT(m4e_remote_fmi3GetFloat64(r, all, 1, found, 1) == M4E_LATE);
    EXPECT(channel.late_function == M4E_fmi3SetFloat64 && channel.late_status == 3);
    refuses = 0;

    char *const large = memset(calloc(ENOUGH, 1), 'x', LARGE);
    const char *const words[] = {"one", "", large}, *read[3];
    EXPECT(!m4e_remote_fmi3SetString(r, all, 3, words, 3));
    EXPECT(!m4e_remote_fmi3GetString(r, all, 3, read, 3));
    for (int k = 0; k < 3; ++k) EXPECT(strcmp(words[k], read[k]) == 0);

    void *state = NULL;
    size_t size = 0;
    EXPECT(!m4e_remote_fmi3GetFMUState(r, &state) && state);
    EXPECT(!m4e_remote_fmi3SerializedFMUStateSize(r, state, &size) && size == LARGE);
    EXPECT(!m4e_remote_fmi3SerializeFMUState(r, state, large, size) && large[LARGE - 1] == 7);
    EXPECT(!m4e_remote_fmi3GetDirectionalDerivative(r, all + 3, 2, all + 5, 1, &late, 1, found, 2));
    EXPECT(found[0] == -2.0 && found[1] == -1.0);
    EXPECT(m4e_remote_fmi3Terminate(r) == 3); /* it has no such function */

    for (int k = 0; k < 12; ++k) { /* from t = 10 s on there are events: nothing is read ahead */
        bool event = false, end = false, early = false;
        double reached = 0.0;
        reads = 0;
        if (k % 2) m4e_remote_begin_3(r, k, 1.0, 1);
        EXPECT(!m4e_remote_fmi3DoStep(r, k, 1.0, 1, &event, &end, &early, &reached));
        EXPECT(reached == k + 1.0 && event == (k >= 10) && !end && !early);
        EXPECT(reads == (k >= 2 && k < 10));
        EXPECT(!m4e_remote_fmi3GetFloat64(r, all, 1, &found[0], 1));
    }
    EXPECT(messages == 12);
    m4e_remote_fmi3FreeInstance(r);
    EXPECT(m4e_remote_end(r) == 0);
    pthread_join(server, (void **)&state);
    EXPECT(!state);
    m4e_remote_free(r);
    free(large);
    return 0;
}
