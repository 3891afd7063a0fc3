/* Mutations of programs in their binary form, and of texts. */
#ifndef MUTATE_H
#define MUTATE_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static uint64_t state;

static uint32_t next(uint32_t limit) { /* xorshift */
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return limit ? (uint32_t)(state >> 32) % limit : 0;
}

static void put(uint8_t *at, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) at[i] = (uint8_t)(value >> (8 * i));
}

/* Right size and checksum, so that the checks behind those are reached. */
static void repair(uint8_t *data, size_t size) {
    uint32_t crc = 0xffffffff;
    put(data + 16, size, 8);
    for (size_t i = 16; i < size; ++i) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xedb88320 & (0 - (crc & 1)));
    }
    put(data + 12, ~crc, 4);
}

/* One to four changes; `room` is that of `data`. The new size is returned. */
static size_t mutate(uint8_t *data, size_t size, size_t room) {
    static const uint32_t odd[] = {0, 1, 2, 0x7f, 0xff, 0x100, 0xffff, 0xffffff, 0x7fffffff,
                                   0xfffffffe, 0xffffffff};
    for (uint32_t i = 1 + next(4); i-- > 0 && size > 0;) {
        const uint32_t at = next((uint32_t)size), kind = next(8);
        if (kind == 0) data[at] ^= (uint8_t)(1u << next(8));
        if (kind == 1) data[at] = (uint8_t)next(256);
        if (kind == 2) size = at;
        if (kind == 3 && size + 4 <= room) {
            memmove(data + at + 4, data + at, size - at);
            size += 4;
        }
        if (kind >= 4 && size > 28) { /* a word of the header, or of the body */
            const uint32_t word = kind < 6 ? 24 + 4 * next(10) : at & ~3u;
            if (word + 4 <= size) put(data + word, kind == 7 ? next(64) : odd[next(11)], 4);
        }
    }
    return size;
}

#endif
