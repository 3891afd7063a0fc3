/* A worker whose answers have damaged sizes and contents: the client takes none for good. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "remote_client.h"

enum { TEXTS = 3 };
static m4e_channel channel;
static m4e_remote *client;
static const uint64_t SIZES[] = {0,          1,          TEXTS - 1,      TEXTS,      M4E_ROOM,
                                 UINT64_MAX, PTRDIFF_MAX, UINT64_MAX - 1, 8 * TEXTS, 8 * TEXTS + 1};

static void *answer(void *size) {
    uint32_t seen = 0;
    int32_t eager = 0;
    for (;;) {
        m4e_remote_wait(&channel.asked, seen, &channel.asleep[1], &channel.lost, &eager);
        seen = atomic_load(&channel.asked);
        if (channel.function == M4E_END) return NULL;
        channel.taken = *(const uint64_t *)size;
        channel.status = 0;
        memset(channel.answer, channel.function == M4E_fmi3GetBinary ? 0xff : 0, M4E_ROOM);
        atomic_fetch_add(&channel.answered, 1);
        m4e_remote_wake(&channel.answered, &channel.asleep[0]);
    }
}

M4E_API int m4e_remote_fmi3GetBinary(void *remote, const vr *references, size_t count,
                                     size_t *sizes, const unsigned char **values, size_t size);

int main(void) {
    int lost = 0;
    for (size_t k = 0; k < sizeof SIZES / sizeof *SIZES; ++k) {
        uint64_t size = SIZES[k];
        pthread_t worker;
        memset(&channel, 0, sizeof channel);
        client = m4e_remote_new(&channel);
        if (!client || pthread_create(&worker, NULL, answer, &size)) return 1;
        const vr references[TEXTS] = {0, 1, 2};
        const char *texts[TEXTS];
        size_t sizes[TEXTS];
        const unsigned char *binaries[TEXTS];
        const int status =
            m4e_remote_get_texts(client, M4E_fmi2GetString, references, TEXTS, texts, TEXTS);
        for (int t = 0; t < TEXTS && !status; ++t)
            if (*texts[t]) return 2;
        lost += status == M4E_LOST;
        lost += m4e_remote_fmi3GetBinary(client, references, TEXTS, sizes, binaries, TEXTS) ==
                M4E_LOST;
        m4e_remote_end(client);
        pthread_join(worker, NULL);
        m4e_remote_free(client);
    }
    printf("%d lost\n", lost);
    return 0;
}
