/* Requests and answers between two processes: a counter each way, and a wait for it. */
#define _GNU_SOURCE
#include "loop.h"
#include "remote.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif
#ifdef _WIN32
#include <windows.h>
#else
#include <sched.h>
#endif

enum { CLIENT, SERVER };
enum { LOOKS = 64 };              /* between two looks at the clock */
enum { TRY = 4 };                 /* waits without spinning after a spin that did not help */
static const double SPIN = 50e-6; /* s; a call that is shorter is answered without sleep */
static const long NAP = 100000000; /* ns; after which a sleeper looks by itself */

typedef void logger_1(void *component, const char *name, int status, const char *category,
                      const char *format, ...);
typedef void logger_3(void *environment, int status, const char *category, const char *text);

#define NAME(name, shape, type) #name,
static const char *const NAMES[] = {M4E_REMOTE_FUNCTIONS(NAME)};

const char *m4e_remote_name(uint32_t function) {
    return function < sizeof NAMES / sizeof *NAMES ? NAMES[function] : NULL;
}

const char *m4e_remote_text(const m4e_remote *r) { return r->channel->text; }

size_t m4e_remote_size(void) { return sizeof(m4e_channel); }

size_t m4e_remote_padded(size_t size) { return (size + 7) / 8 * 8; }

/* ---- waiting ---- */

double m4e_seconds(void) {
#ifdef _WIN32
    LARGE_INTEGER now, per_second;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&per_second);
    return (double)now.QuadPart / (double)per_second.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
}

static void relax(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/* Sleep until `word` is no longer `old`, or for a nap. */
static void nap(_Atomic uint32_t *word, uint32_t old, double waited) {
#ifdef __linux__
    const struct timespec limit = {0, NAP};
    (void)waited;
    syscall(SYS_futex, word, FUTEX_WAIT, old, &limit, NULL, 0);
#elif defined _WIN32
    (void)word, (void)old;
    Sleep(waited < 1e-3 ? 0 : 1);
#else
    const double share = waited / 16 < 1e-3 ? waited / 16 : 1e-3;
    const struct timespec pause = {0, (long)(1e9 * share)};
    (void)word, (void)old;
    nanosleep(&pause, NULL);
#endif
}

void m4e_remote_wake(_Atomic uint32_t *word, _Atomic uint32_t *asleep) {
    if (!atomic_load(asleep)) return;
#ifdef __linux__
    syscall(SYS_futex, word, FUTEX_WAKE, 1, NULL, NULL, 0);
#else
    (void)word;
#endif
}

/* Let others have the processor: two workers and their master may share two of them. */
static void yield(void) {
#ifdef _WIN32
    SwitchToThread();
#else
    sched_yield();
#endif
}

static int spins(_Atomic uint32_t *word, uint32_t old, double begin) {
    do {
        for (int k = 0; k < LOOKS; ++k) {
            if (atomic_load(word) != old) return 1;
            relax();
        }
        yield();
    } while (m4e_seconds() - begin < SPIN);
    return 0;
}

int m4e_remote_wait(_Atomic uint32_t *word, uint32_t old, _Atomic uint32_t *asleep,
                    _Atomic int32_t *lost, int32_t *eager) {
    if (atomic_load(word) != old) return 1;
    const double begin = m4e_seconds();
    if (*eager > 0 || ++*eager > -1) { /* eager: 1, or how many waits up to the next try */
        if (spins(word, old, begin)) {
            *eager = 1;
            return 1;
        }
        *eager = -TRY;
    }
    atomic_store(asleep, 1);
    while (atomic_load(word) == old && !atomic_load(lost)) nap(word, old, m4e_seconds() - begin);
    atomic_store(asleep, 0);
    return atomic_load(word) != old;
}

/* ---- the client's side ---- */

m4e_remote *m4e_remote_new(m4e_channel *channel) {
    m4e_remote *r = calloc(1, sizeof *r);
    if (r) r->channel = channel;
    return r;
}

void m4e_remote_free(m4e_remote *r) {
    if (r) {
        free(r->kept);
        free(r->ahead.references);
        free(r->ahead.values);
    }
    free(r);
}

int m4e_remote_flush(m4e_remote *r) {
    m4e_remote_begin(r);
    return r->late_size ? m4e_remote_ask(r, M4E_SETS, NULL, 0, NULL, 0) : 0;
}

int m4e_remote_end(m4e_remote *r) {
    return r->stepping || m4e_remote_post(r, M4E_END, NULL, 0);
}

void m4e_remote_give_up(m4e_channel *c) {
    atomic_store(&c->lost, 1);
    m4e_remote_wake(&c->answered, &c->asleep[CLIENT]);
}

static void hear(const m4e_remote *r) {
    m4e_channel *c = r->channel;
    const m4e_listener *l = &r->listener;
    c->text[M4E_TEXT_ROOM - 1] = 0;
    if (!l->logger) return;
    if (l->version == 3)
        ((logger_3 *)l->logger)(l->environment, c->status, "", c->text);
    else
        ((logger_1 *)l->logger)(l->environment, l->name, c->status, "", "%s", c->text);
}

static void notify(m4e_channel *c) {
    atomic_fetch_add(&c->asked, 1);
    m4e_remote_wake(&c->asked, &c->asleep[SERVER]);
}

/* One request and its answer, messages in between. */
static int exchange(m4e_remote *r) {
    m4e_channel *c = r->channel;
    for (;;) {
        if (!m4e_remote_wait(&c->answered, r->seen, &c->asleep[CLIENT], &c->lost, &r->eager)) break;
        r->seen = atomic_load(&c->answered);
        if (!c->is_message) return c->status;
        hear(r);
        if (atomic_load(&c->lost)) break;
        notify(c);
    }
    return M4E_LOST;
}

int m4e_remote_await(m4e_remote *r) {
    const int status = r->late_answer ? r->late_answer : exchange(r);
    r->stepping = r->late_answer = 0;
    return status;
}

m4e_channel *m4e_remote_begin(m4e_remote *r) {
    if (r->stepping) m4e_remote_await(r);
    if (r->has_stepped) r->ahead.seen = 0;
    r->has_stepped = r->ahead.ready = 0;
    return r->channel;
}

int m4e_remote_set_late(m4e_remote *r, uint32_t function, const m4e_given *given, int count,
                        uint64_t references, uint64_t values) {
    m4e_late head = {function, 0, {references, values}, 0};
    for (int k = 0; k < count; ++k) head.size += m4e_remote_padded(given[k].size);
    if (r->late_size + sizeof head + head.size > sizeof r->late) return 1;
    unsigned char *at = r->late + r->late_size;
    memcpy(at, &head, sizeof head);
    at += sizeof head;
    for (int k = 0; k < count; ++k) {
        memcpy(at, given[k].at, given[k].size);
        at += m4e_remote_padded(given[k].size);
    }
    r->late_size += sizeof head + head.size;
    return 0;
}

static void take_late(m4e_remote *r) {
    r->channel->late = r->late_size;
    memcpy(r->channel->request, r->late, r->late_size);
    r->late_size = 0;
}

/* More than fits, piece by piece; numbers and reals stay as they are. */
static int send_pieces(m4e_remote *r, const unsigned char *whole, size_t size) {
    m4e_channel *c = r->channel;
    for (size_t place = 0; place < size; place += M4E_ROOM) {
        const size_t rest = size - place;
        c->function = M4E_PIECE;
        c->given = size;
        c->taken = place;
        memcpy(c->request, whole + place, rest < M4E_ROOM ? rest : M4E_ROOM);
        notify(c);
        if (exchange(r)) return M4E_LOST;
    }
    return 0;
}

/* What does not fit beside values to be set. */
static int post_large(m4e_remote *r, const m4e_given *given, int count, size_t size) {
    m4e_channel *c = r->channel;
    unsigned char *whole = calloc(1, size), *at = whole;
    if (!whole) return M4E_LOST;
    take_late(r);
    c->function = M4E_SETS;
    notify(c);
    int status = exchange(r);
    for (int k = 0; k < count && !status; ++k) {
        memcpy(at, given[k].at, given[k].size);
        at += m4e_remote_padded(given[k].size);
    }
    if (!status) status = send_pieces(r, whole, size);
    free(whole);
    return status;
}

int m4e_remote_post(m4e_remote *r, uint32_t function, const m4e_given *given, int count) {
    m4e_channel *c = r->channel;
    size_t size = 0;
    if (atomic_load(&c->lost)) return M4E_LOST;
    for (int k = 0; k < count; ++k) size += m4e_remote_padded(given[k].size);
    atomic_fetch_add(&c->calls, 1);
    atomic_store(&c->busy, 1);
    if (r->late_size + size > M4E_ROOM) {
        const int status = post_large(r, given, count, size);
        if (status) return status;
        c->late = 0;
    } else {
        take_late(r);
        unsigned char *at = c->request + c->late;
        for (int k = 0; k < count; ++k) {
            if (given[k].size) memcpy(at, given[k].at, given[k].size);
            at += m4e_remote_padded(given[k].size);
        }
    }
    c->function = function;
    c->given = size;
    c->taken = 0;
    notify(c);
    return 0;
}

/* `size` bytes of the answer, from `place`. */
static int fetch(m4e_remote *r, size_t place, void *to, size_t size) {
    m4e_channel *c = r->channel;
    const uint64_t total = c->taken;
    if (place + size > total) return M4E_LOST;
    if (total <= M4E_ROOM) {
        if (size) memcpy(to, c->answer + place, size);
        return 0;
    }
    for (size_t done = 0; done < size;) {
        const size_t rest = size - done, part = rest < M4E_ROOM ? rest : M4E_ROOM;
        c->function = M4E_FETCH;
        c->given = place + done;
        c->taken = part;
        notify(c);
        if (exchange(r)) return M4E_LOST;
        memcpy((char *)to + done, c->answer, part);
        done += part;
    }
    c->taken = total;
    return 0;
}

int m4e_remote_ask(m4e_remote *r, uint32_t function, const m4e_given *given, int given_count,
                   const m4e_wanted *wanted, int wanted_count) {
    size_t place = 0;
    int status = m4e_remote_post(r, function, given, given_count);
    if (status) return status;
    status = m4e_remote_await(r);
    for (int k = 0; k < wanted_count && status < M4E_LOST; ++k) {
        if (fetch(r, place, wanted[k].at, wanted[k].size)) return M4E_LOST;
        place += m4e_remote_padded(wanted[k].size);
    }
    return status;
}

char *m4e_remote_answer(m4e_remote *r, const char **end) {
    const uint64_t size = r->channel->taken; /* read once: the worker's memory is this one */
    if (size >= PTRDIFF_MAX) return NULL;
    if (size + 1 > r->kept_size) {
        char *kept = realloc(r->kept, size + 1);
        if (!kept) return NULL;
        r->kept = kept;
        r->kept_size = size + 1;
    }
    r->kept[size] = 0;
    *end = r->kept + size;
    return fetch(r, 0, r->kept, size) ? NULL : r->kept;
}
