/* A worker whose answers have damaged sizes and contents: the client takes none for good. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "remote.h"

enum { TEXTS = 3, ROOM = sizeof((m4e_way *)0)->bytes };
static m4e_channel channel;
/* Bytes of an answer after its head, and what they are filled with. */
static const struct {
    uint64_t size;
    int fill;
} LIES[] = {{0, 0},          {1, 0},          {8 * TEXTS, 0},       {8 * TEXTS + 1, 0},
            {ROOM - 16, 0},  {ROOM - 16, 1},  {ROOM - 16, 0xff},    {ROOM, 0},
            {UINT64_MAX, 0}, {PTRDIFF_MAX, 0}, {UINT64_MAX - 16, 0}, {UINT64_MAX - 24, 0}};

static void *answer(void *lie) {
    const size_t k = *(const size_t *)lie;
    m4e_end end = {.channel = &channel, .side = M4E_SERVER};
    while (m4e_hear(&end) == M4E_REQUEST) {
        m4e_way *way = &channel.way[M4E_CLIENT];
        memset(way->bytes, LIES[k].fill, ROOM);
        memset(way->bytes, 0, sizeof(m4e_answer));
        way->kind = M4E_ANSWER;
        way->size = sizeof(m4e_answer) + LIES[k].size;
        ++way->sent;
        m4e_wake(way);
    }
    free(end.in.at);
    return NULL;
}

void *m4e_remote_new(m4e_channel *channel);
void m4e_remote_free(void *remote);
int m4e_remote_end(void *remote);
#define PROTOTYPE(name, signature, T) int m4e_remote_##name(void *remote signature(PARAMETER, T));
PROTOTYPE(fmi2GetString, GET, m4e_text)
PROTOTYPE(fmi2DoStep, STEP, int)
PROTOTYPE(fmi2GetReal, GET, double)

int main(void) {
    int lost = 0;
    for (size_t k = 0; k < sizeof LIES / sizeof *LIES; ++k) {
        pthread_t worker;
        memset(&channel, 0, sizeof channel);
        void *client = m4e_remote_new(&channel);
        if (!client || pthread_create(&worker, NULL, answer, &k)) return 1;
        const uint32_t references[TEXTS] = {0, 1, 2};
        const char *texts[TEXTS];
        double values[TEXTS];
        const int status = m4e_remote_fmi2GetString(client, references, TEXTS, texts);
        for (int t = 0; t < TEXTS && !status; ++t)
            if (texts[t]) return 2;
        lost += status == M4E_LOST;
        for (int step = 0; step < 4; ++step) { /* from the third on with values read ahead */
            lost += m4e_remote_fmi2DoStep(client, 0.0, 1.0, 1) == M4E_LOST;
            lost += m4e_remote_fmi2GetReal(client, references, TEXTS, values) == M4E_LOST;
        }
        m4e_remote_end(client);
        pthread_join(worker, NULL);
        m4e_remote_free(client);
    }
    printf("%d lost\n", lost);
    return 0;
}
