/* Requests and answers between two processes: a counter each way, and a wait for it. */
#define _GNU_SOURCE
#include "remote.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#elif defined _WIN32
#include <windows.h>
#endif

enum { CLIENT, SERVER };
enum { LOOKS = 64 };              /* between two looks at the clock */
static const double SPIN = 20e-6; /* s; a call that is shorter is answered without sleep */
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

static double seconds(void) {
    struct timespec now;
#ifdef _WIN32
    timespec_get(&now, TIME_UTC);
#else
    clock_gettime(CLOCK_MONOTONIC, &now);
#endif
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
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

int m4e_remote_wait(_Atomic uint32_t *word, uint32_t old, _Atomic uint32_t *asleep,
                    _Atomic int32_t *lost) {
    const double begin = seconds();
    double waited = 0.0;
    while (waited < SPIN) {
        for (int k = 0; k < LOOKS; ++k) {
            if (atomic_load(word) != old) return 1;
            relax();
        }
        waited = seconds() - begin;
    }
    atomic_store(asleep, 1);
    while (atomic_load(word) == old && !atomic_load(lost)) {
        nap(word, old, waited);
        waited = seconds() - begin;
    }
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
    if (r) free(r->kept);
    free(r);
}

void m4e_remote_end(m4e_remote *r) {
    if (!r->stepping) m4e_remote_post(r, M4E_END, NULL, 0);
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
        if (!m4e_remote_wait(&c->answered, r->seen, &c->asleep[CLIENT], &c->lost)) break;
        r->seen = atomic_load(&c->answered);
        if (!c->is_message) return c->status;
        hear(r);
        if (atomic_load(&c->lost)) break;
        notify(c);
    }
    return M4E_LOST;
}

int m4e_remote_await(m4e_remote *r) {
    const int status = exchange(r);
    r->stepping = 0;
    return status;
}

m4e_channel *m4e_remote_begin(m4e_remote *r) {
    if (r->stepping) m4e_remote_await(r);
    return r->channel;
}

/* More than fits, piece by piece; numbers and reals stay as they are. */
static int send_pieces(m4e_remote *r, const unsigned char *whole, size_t size) {
    m4e_channel *c = r->channel;
    const uint32_t function = c->function;
    for (size_t place = 0; place < size; place += M4E_ROOM) {
        const size_t rest = size - place;
        c->function = M4E_PIECE;
        c->given = size;
        c->taken = place;
        memcpy(c->request, whole + place, rest < M4E_ROOM ? rest : M4E_ROOM);
        notify(c);
        if (exchange(r)) return M4E_LOST;
    }
    c->function = function;
    return 0;
}

int m4e_remote_post(m4e_remote *r, uint32_t function, const m4e_given *given, int count) {
    m4e_channel *c = r->channel;
    size_t size = 0;
    if (atomic_load(&c->lost)) return M4E_LOST;
    c->function = function;
    atomic_fetch_add(&c->calls, 1);
    atomic_store(&c->busy, 1);
    for (int k = 0; k < count; ++k) size += m4e_remote_padded(given[k].size);
    unsigned char *whole = size <= M4E_ROOM ? c->request : calloc(1, size), *at = whole;
    int status = whole ? 0 : M4E_LOST;
    for (int k = 0; k < count && whole; ++k) {
        if (given[k].size) memcpy(at, given[k].at, given[k].size);
        at += m4e_remote_padded(given[k].size);
    }
    if (whole && whole != c->request) {
        status = send_pieces(r, whole, size);
        free(whole);
    }
    c->given = size;
    c->taken = 0;
    if (!status) notify(c);
    return status;
}

/* `size` bytes of the answer, from `place`. */
static int fetch(m4e_remote *r, size_t place, void *to, size_t size) {
    m4e_channel *c = r->channel;
    const uint64_t total = c->taken;
    if (place + size > total) return M4E_LOST;
    if (total <= M4E_ROOM) {
        memcpy(to, c->answer + place, size);
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
    if (m4e_remote_post(r, function, given, given_count)) return M4E_LOST;
    const int status = m4e_remote_await(r);
    for (int k = 0; k < wanted_count && status != M4E_LOST; ++k) {
        if (fetch(r, place, wanted[k].at, wanted[k].size)) return M4E_LOST;
        place += m4e_remote_padded(wanted[k].size);
    }
    return status;
}

char *m4e_remote_answer(m4e_remote *r) {
    const size_t size = r->channel->taken;
    if (size + 1 > r->kept_size) {
        char *kept = realloc(r->kept, size + 1);
        if (!kept) return NULL;
        r->kept = kept;
        r->kept_size = size + 1;
    }
    r->kept[size] = 0;
    return fetch(r, 0, r->kept, size) ? NULL : r->kept;
}
