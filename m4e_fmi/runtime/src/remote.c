/* Values as bytes, and parcels of them between two processes: a counter each way. */
#ifndef _WIN32
#define _GNU_SOURCE
#include "remote.h"

#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "loop.h"
#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

enum { LOOKS = 64 };               /* between two looks at the clock */
enum { TRY = 4 };                  /* waits without spinning after a spin that did not help */
static const double SPIN = 50e-6;  /* s; a call that is shorter is answered without sleep */
static const long NAP = 100000000; /* ns; after which a sleeper looks by itself */

/* ---- values ---- */

static size_t padded(size_t size) { return (size + 7) / 8 * 8; }

void *m4e_extend(m4e_bytes *b, size_t size) {
    const size_t end = b->size + padded(size);
    if (end + 1 > b->room) {
        unsigned char *more = realloc(b->at, 2 * end + 64);
        if (!more) {
            b->failed = 1;
            return NULL;
        }
        b->at = more;
        b->room = 2 * end + 64;
    }
    unsigned char *place = b->at + b->size;
    if (size % 8) memset(b->at + end - 8, 0, 8);
    b->at[end] = 0;
    b->size = end;
    return place;
}

void m4e_put(m4e_bytes *b, const void *value, size_t size) {
    void *place = m4e_extend(b, size);
    if (place && size) memcpy(place, value, size);
}

void m4e_put_blob(m4e_bytes *b, const void *bytes, size_t size) {
    m4e_put(b, &size, sizeof size);
    m4e_put(b, bytes, size);
}

void m4e_put_all(m4e_bytes *b, const void *values, size_t count, size_t size) {
    const m4e_text *text = values;
    if (size) m4e_put(b, values, count * size);
    for (size_t k = 0; k < count && !size; ++k)
        m4e_put_blob(b, text[k], text[k] ? strlen(text[k]) + 1 : 0);
}

void *m4e_take(m4e_bytes *b, size_t size) {
    unsigned char *at = b->at + b->place;
    if (b->place > b->size || size > b->size - b->place) {
        b->failed = 1;
        return NULL;
    }
    b->place += padded(size);
    return at;
}

void *m4e_take_blob(m4e_bytes *b, size_t *size) {
    const size_t *found = m4e_take(b, sizeof *found);
    *size = found ? *found : 0;
    return found ? m4e_take(b, *size) : NULL;
}

const char *m4e_take_text(m4e_bytes *b) {
    size_t size;
    const char *text = m4e_take_blob(b, &size);
    if (!text || !size) return NULL;
    b->failed |= text[size - 1] != 0;
    return text[size - 1] ? NULL : text;
}

/* ---- waiting ---- */

static void relax(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/* Sleep until a parcel has come, or for a nap. */
static void nap(m4e_way *way, uint32_t seen, double waited) {
#ifdef __linux__
    const struct timespec limit = {0, NAP};
    (void)waited;
    syscall(SYS_futex, &way->sent, FUTEX_WAIT, seen, &limit, NULL, 0);
#else
    const double share = waited / 16 < 1e-3 ? waited / 16 : 1e-3;
    const struct timespec pause = {0, (long)(1e9 * share)};
    (void)way, (void)seen;
    nanosleep(&pause, NULL);
#endif
}

void m4e_wake(m4e_way *way) {
    if (!atomic_load(&way->asleep)) return;
#ifdef __linux__
    syscall(SYS_futex, &way->sent, FUTEX_WAKE, 1, NULL, NULL, 0);
#endif
}

/* Lets others have the processor meanwhile: two workers and their master may share two of them. */
static int spins(const m4e_way *way, uint32_t seen, double begin) {
    do {
        for (int k = 0; k < LOOKS; ++k) {
            if (atomic_load(&way->sent) != seen) return 1;
            relax();
        }
        sched_yield();
    } while (m4e_seconds() - begin < SPIN);
    return 0;
}

/* Until a parcel has come, or the other side is lost. */
static void wait(m4e_end *e, m4e_way *way) {
    const double begin = m4e_seconds();
    if (e->eager >= 0 || ++e->eager == 0) {
        const int helped = spins(way, e->seen, begin);
        e->eager = helped ? 1 : -TRY;
        if (helped) return;
    }
    atomic_store(&way->asleep, 1);
    while (atomic_load(&way->sent) == e->seen && !atomic_load(&e->channel->lost))
        nap(way, e->seen, m4e_seconds() - begin);
    atomic_store(&way->asleep, 0);
}

uint32_t m4e_await_parcel(m4e_end *e) {
    m4e_way *way = &e->channel->way[e->side];
    if (atomic_load(&way->sent) == e->seen) wait(e, way);
    if (atomic_load(&way->sent) == e->seen) return M4E_NOTHING;
    e->seen = atomic_load(&way->sent);
    return way->kind;
}

/* ---- parcels ---- */

static void hand_over(m4e_end *e, uint32_t kind, const void *bytes, size_t size) {
    m4e_way *way = &e->channel->way[!e->side];
    way->kind = kind;
    way->size = size;
    if (size) memcpy(way->bytes, bytes, size);
    atomic_fetch_add(&way->sent, 1);
    m4e_wake(way);
}

void m4e_send(m4e_end *e, uint32_t kind, const void *bytes, size_t size) {
    const unsigned char *at = bytes;
    const size_t room = sizeof e->channel->way->bytes;
    for (; size > room; size -= room, at += room) {
        hand_over(e, M4E_PART, at, room);
        if (m4e_await_parcel(e) != M4E_GO_ON) return;
    }
    hand_over(e, kind, at, size);
}

uint32_t m4e_hear(m4e_end *e) {
    const m4e_way *way = &e->channel->way[e->side];
    e->in.size = e->in.place = 0;
    e->in.failed = 0;
    for (;;) {
        const uint32_t kind = m4e_await_parcel(e);
        const size_t size = way->size; /* read once: the memory is another's, too */
        void *place = size <= sizeof way->bytes ? m4e_extend(&e->in, size) : NULL;
        if (!kind || !place) return M4E_NOTHING;
        memcpy(place, way->bytes, size);
        if (kind != M4E_PART) return kind;
        hand_over(e, M4E_GO_ON, NULL, 0);
    }
}
#endif
