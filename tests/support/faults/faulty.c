/* The functions of an FMU with faults, around those of an honest one (honest_...), which another object
 * file has. FMI is 1, 2 or 3; IDENTIFIER begins the names of FMI 1.0.
 *
 * The folder M4E_TEST_FAULTS arms a fault from outside: its file `plan` has the line "component call
 * kind from count". The fault strikes in that call once the component has been asked to step to `from`
 * seconds or beyond, from the count-th such call on (some strike in that call only). The file `calls` has a byte for each such call, so
 * that they are counted over all processes.
 *
 * An FMU in which no fault strikes is a witness: it checks at each call that rounding, locale and
 * folder are those of its first one, and answers Error if not.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <limits.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { OK, WARNING, DISCARD, ERROR, FATAL };

void throw_an_exception(void) __asm__("_ZSt17__throw_bad_allocv"); /* of the C++ library */

typedef struct {
    void *instance, *environment;
    void (*log)(void);
    char name[64];
    double time; /* s, up to which it has been asked to step */
} Known;

static Known known[256];
static char struck[32];       /* kind of the fault that strikes in this call */
static char left[32];         /* kind of the surroundings that each call leaves from now on */
static char folder[PATH_MAX]; /* of the process at the first call */

static Known *of(void *instance) {
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (known[i].instance == instance) return known + i;
    return known;
}

static void tell(Known *k, int status, const char *text) {
#if FMI == 3
    void (*log)(void *, int, const char *, const char *) = (void *)k->log;
    log(k->environment, status, "logStatus", text);
#else
    void (*log)(void *, const char *, int, const char *, const char *, ...) = (void *)k->log;
    log(FMI == 1 ? k->instance : k->environment, k->name, status, "logStatus", "%s", text);
#endif
}

static volatile int deep;
static int overflow_stack(int n) {
    volatile char room[4096];
    room[0] = (char)n;
    return deep ? room[0] : overflow_stack(n + 1) + room[0];
}

static void overflow_heap(void) {
    char *a = malloc(64), *b = malloc(64);
    memset(a, 0x41, 64 + (size_t)(labs(b - a) < 4096 ? labs(b - a) : 0) + 4096);
    for (int i = 0; i < 1000; i++) free(malloc((size_t)(i * 100)));
    free(b), free(a);
    abort(); /* where the allocator did not notice */
}

static void hog(void) {
    for (;;) {
        char *p = malloc(1 << 24);
        if (!p) abort();
        memset(p, 1, 1 << 24);
    }
}

static void *stay(void *unused) {
    for (;;) usleep(1000);
    return unused;
}

static void *crash_later(void *unused) {
    usleep(20000);
    abort();
    return unused;
}

static void begin(void *(*does)(void *)) {
    pthread_t thread;
    pthread_create(&thread, NULL, does, NULL);
    pthread_detach(thread);
}

static void leave_a_thread(void) { begin(stay); }
static void leave_a_crash(void) { begin(crash_later); }

static void spin(void) {
    for (volatile int on = 1; on;) continue;
}

static void divide(void) {
    volatile int zero = 0, one = 1;
    one /= zero;
}

static void write_to_null(void) { *(volatile int *)0 = 1; }

static void sleep_on(void) {
    for (;;) pause();
}

static void fork_one(void) {
    if (!fork()) sleep_on();
}

static void return_twice(void) { fork(); }
static void be_slow(void) { usleep(5000); }
static void stop(void) { raise(SIGSTOP); }
static void kill_oneself(void) { raise(SIGKILL); }
static void exit_0(void) { exit(0); }
static void at_once_0(void) { _exit(0); }
static void end_thread(void) { pthread_exit(NULL); }

/* What happens instead of a call. */
static const struct {
    const char *kind;
    void (*does)(void);
} deeds[] = {
    {"segv", write_to_null}, {"abort", abort}, {"throw", throw_an_exception},
    {"heap", overflow_heap}, {"fpe", divide}, {"exit", exit_0}, {"_exit", at_once_0},
    {"spin", spin}, {"sleep", sleep_on}, {"sigstop", stop}, {"sigkill", kill_oneself},
    {"pthread_exit", end_thread}, {"thread", leave_a_thread}, {"fork", fork_one}, {"hog", hog},
    {"slow", be_slow}, {"late", leave_a_crash}, {"twin", return_twice},
};

enum { FLOOD = 1000 };

static void write_floods(void) {
    for (int i = 0; i < FLOOD; i++) {
        printf("{\"the pump\": %d, \"writes\": \"to stdout\"}\n", i);
        fprintf(stderr, "and line %d to stderr\n", i);
    }
    fflush(stdout);
}

static void change_locale(void) {
    const char *place = getenv("M4E_TEST_FAULTS");
    setenv("LOCPATH", place, 1);
    if (!setlocale(LC_ALL, "de_DE.UTF-8") || *localeconv()->decimal_point != ',') abort();
}

/* What a call leaves behind when it returns. */
static void afterwards(Known *k) {
    if (!strcmp(struck, "rounding") || !strcmp(struck, "locale") || !strcmp(struck, "chdir"))
        strcpy(left, struck);
    if (!strcmp(left, "rounding")) fesetround(FE_UPWARD);
    if (!strcmp(left, "locale")) change_locale();
    if (!strcmp(left, "chdir") && chdir("/")) abort();
    if (!strcmp(struck, "close"))
        for (int i = 0; i < 1024; i++) close(i);
    if (!strcmp(struck, "stdout")) write_floods();
    if (!strcmp(struck, "log"))
        for (int i = 0; i < FLOOD; i++) tell(k, i % 2 ? ERROR : WARNING, "the pump complains");
    if (!strcmp(struck, "signals"))
        for (int i = 1; i < 32; i++) signal(i, SIG_IGN);
}

/* Its own calls are made in the surroundings that it needs. */
static void restore(void) {
    if (!strcmp(left, "rounding")) fesetround(FE_TONEAREST);
    if (!strcmp(left, "locale")) setlocale(LC_ALL, "C");
    if (!strcmp(left, "chdir") && chdir(folder)) abort();
}

static int strikes_once(const char *kind) {
    const char *once[] = {"thread", "late", "fork", "twin", "stdout", "log", "close"};
    for (size_t i = 0; i < sizeof once / sizeof *once; i++)
        if (!strcmp(kind, once[i])) return 1;
    return 0;
}

/* The fault that is armed for a call, if its time has come. */
static int is_armed(Known *k, const char *call) {
    const char *place = getenv("M4E_TEST_FAULTS");
    char path[PATH_MAX], line[512], component[64], planned[32];
    double from;
    long count;
    if (!place) return 0;
    snprintf(path, sizeof path, "%s/plan", place);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return 0;
    ssize_t size = read(file, line, sizeof line - 1);
    close(file);
    line[size < 0 ? 0 : size] = 0;
    if (sscanf(line, "%63s %31s %31s %lf %ld", component, planned, struck, &from, &count) == 5 &&
        !strcmp(component, k->name) && !strcmp(planned, call) && k->time >= from) {
        snprintf(path, sizeof path, "%s/calls", place);
        file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
        if (write(file, "", 1) != 1) abort();
        off_t calls = lseek(file, 0, SEEK_END);
        close(file);
        if (calls == count || (calls > count && !strikes_once(struck))) return 1;
    }
    *struck = 0;
    return 0;
}

/* Status of a witness: Error, with words, if its surroundings are not those of its first call. */
static int looked(Known *k) {
    char now[PATH_MAX] = "";
    const char *changed = NULL;
    if (!*folder && !getcwd(folder, sizeof folder)) strcpy(folder, "?");
    if (fegetround() != FE_TONEAREST) changed = "the rounding mode has changed";
    if (*localeconv()->decimal_point != '.') changed = "the locale has changed";
    if (!getcwd(now, sizeof now)) strcpy(now, "?");
    if (strcmp(now, folder)) changed = "the folder has changed";
    if (changed) tell(k, ERROR, changed);
    return changed ? ERROR : OK;
}

/* 0: the honest call is made, then `afterwards`; else the status that is returned instead. */
static int before(Known *k, const char *call) {
    *struck = 0;
    if (*left) restore();
    else if (looked(k)) return ERROR;
    if (!is_armed(k, call)) return OK;
    if (!strcmp(struck, "stack")) return overflow_stack(0);
    for (size_t i = 0; i < sizeof deeds / sizeof *deeds; i++)
        if (!strcmp(struck, deeds[i].kind)) deeds[i].does();
    const char *words[] = {"ok", "warning", "discard", "error", "fatal"};
    for (int status = DISCARD; status <= FATAL; status++)
        if (!strcmp(struck, words[status])) {
            tell(k, status, "the pump ran dry");
            return status;
        }
    if (!strcmp(struck, "negative")) return -1;
    return OK;
}

#define JOIN(a, b) a##_##b
#define NAMED(a, b) JOIN(a, b)
#if FMI == 1
#define OWN(name) NAMED(IDENTIFIER, name)
#else
#define OWN(name) name
#endif

#define FUNCTION(call, function, parameters, arguments)  \
    int honest_##function parameters;                    \
    int OWN(function) parameters {                       \
        Known *k = of(c);                            \
        int status = before(k, call);                \
        if (status) return status;                   \
        status = honest_##function arguments;            \
        afterwards(k);                               \
        return status;                               \
    }
#define STEP(function, parameters, arguments)            \
    int honest_##function parameters;                    \
    int OWN(function) parameters {                       \
        Known *k = of(c);                            \
        k->time = t + h;                             \
        int status = before(k, "step");              \
        if (status) return status;                   \
        status = honest_##function arguments;            \
        afterwards(k);                               \
        return status;                               \
    }
#define GETTER(function, parameters, arguments)          \
    int honest_##function parameters;                    \
    int OWN(function) parameters {                       \
        Known *k = of(c);                            \
        int status = before(k, "get");               \
        if (status) return status;                   \
        status = honest_##function arguments;            \
        for (size_t i = 0; i < n; i++) {             \
            if (!strcmp(struck, "nan")) v[i] = NAN;  \
            if (!strcmp(struck, "inf")) v[i] = INFINITY; \
        }                                            \
        afterwards(k);                               \
        return status;                               \
    }
#define FREEING(function)                                \
    void honest_##function(void *c);                     \
    void OWN(function)(void *c) {                        \
        Known *k = of(c);                            \
        if (before(k, "free")) return;               \
        honest_##function(c);                            \
        afterwards(k);                               \
        k->instance = NULL;                          \
    }
#define INSTANTIATION(function, parameters, arguments, logger, surroundings) \
    void *honest_##function parameters;                  \
    void *OWN(function) parameters {                     \
        Known *k = of(NULL);                         \
        *k = (Known){.environment = surroundings, .log = logger}; \
        strncpy(k->name, instance, sizeof k->name - 1); \
        if (before(k, "instantiate")) return NULL;   \
        k->instance = honest_##function arguments;       \
        afterwards(k);                               \
        return k->instance;                          \
    }

typedef const unsigned *References;

#if FMI == 1
typedef struct { void (*log)(void); void *others[3]; } Callbacks;
INSTANTIATION(fmiInstantiateSlave,
    (const char *instance, const char *guid, const char *place, const char *mime, double timeout, char visible, char interactive, Callbacks f, char logging),
    (instance, guid, place, mime, timeout, visible, interactive, f, logging), f.log, NULL)
FUNCTION("initialise", fmiInitializeSlave, (void *c, double t0, char stops, double t1), (c, t0, stops, t1))
GETTER(fmiGetReal, (void *c, References r, size_t n, double *v), (c, r, n, v))
FUNCTION("set", fmiSetReal, (void *c, References r, size_t n, const double *v), (c, r, n, v))
STEP(fmiDoStep, (void *c, double t, double h, char fresh), (c, t, h, fresh))
FUNCTION("terminate", fmiTerminateSlave, (void *c), (c))
FREEING(fmiFreeSlaveInstance)
#elif FMI == 2
typedef struct { void (*log)(void); void *others[3], *environment; } Callbacks;
INSTANTIATION(fmi2Instantiate,
    (const char *instance, int type, const char *guid, const char *place, const Callbacks *f, int visible, int logging),
    (instance, type, guid, place, f, visible, logging), f->log, f->environment)
FUNCTION("setup", fmi2SetupExperiment, (void *c, int d, double e, double t0, int stops, double t1), (c, d, e, t0, stops, t1))
FUNCTION("enter", fmi2EnterInitializationMode, (void *c), (c))
FUNCTION("exit", fmi2ExitInitializationMode, (void *c), (c))
GETTER(fmi2GetReal, (void *c, References r, size_t n, double *v), (c, r, n, v))
FUNCTION("set", fmi2SetReal, (void *c, References r, size_t n, const double *v), (c, r, n, v))
STEP(fmi2DoStep, (void *c, double t, double h, int fresh), (c, t, h, fresh))
#ifdef STATE
FUNCTION("save", fmi2GetFMUstate, (void *c, void **s), (c, s))
FUNCTION("restore", fmi2SetFMUstate, (void *c, void *s), (c, s))
FUNCTION("forget", fmi2FreeFMUstate, (void *c, void **s), (c, s))
#endif
#ifdef BYTES
FUNCTION("serialize", fmi2SerializeFMUstate, (void *c, void *s, char *b, size_t n), (c, s, b, n))
FUNCTION("deserialize", fmi2DeSerializeFMUstate, (void *c, const char *b, size_t n, void **s), (c, b, n, s))
#endif
FUNCTION("terminate", fmi2Terminate, (void *c), (c))
FREEING(fmi2FreeInstance)
#else
#include <stdbool.h>
INSTANTIATION(fmi3InstantiateCoSimulation,
    (const char *instance, const char *token, const char *place, bool visible, bool logging, bool events, bool early, References r, size_t n, void *e, void (*log)(void), void (*update)(void)),
    (instance, token, place, visible, logging, events, early, r, n, e, log, update), log, e)
FUNCTION("enter", fmi3EnterInitializationMode, (void *c, bool d, double e, double t0, bool stops, double t1), (c, d, e, t0, stops, t1))
FUNCTION("exit", fmi3ExitInitializationMode, (void *c), (c))
GETTER(fmi3GetFloat64, (void *c, References r, size_t n, double *v, size_t m), (c, r, n, v, m))
FUNCTION("set", fmi3SetFloat64, (void *c, References r, size_t n, const double *v, size_t m), (c, r, n, v, m))
STEP(fmi3DoStep, (void *c, double t, double h, bool final, bool *event, bool *end, bool *early, double *last), (c, t, h, final, event, end, early, last))
#ifdef STATE
FUNCTION("save", fmi3GetFMUState, (void *c, void **s), (c, s))
FUNCTION("restore", fmi3SetFMUState, (void *c, void *s), (c, s))
FUNCTION("forget", fmi3FreeFMUState, (void *c, void **s), (c, s))
#endif
#ifdef BYTES
FUNCTION("serialize", fmi3SerializeFMUState, (void *c, void *s, unsigned char *b, size_t n), (c, s, b, n))
FUNCTION("deserialize", fmi3DeserializeFMUState, (void *c, const unsigned char *b, size_t n, void **s), (c, b, n, s))
#endif
FUNCTION("terminate", fmi3Terminate, (void *c), (c))
FREEING(fmi3FreeInstance)
#endif
