/* Shared by remote_server.c, which obeys requests, and remote_shapes.c, which calls the FMU. */
#ifndef M4E_REMOTE_SERVER_H
#define M4E_REMOTE_SERVER_H

#include "remote.h"

enum { M4E_REMOTE_WARNING = 1, M4E_REMOTE_ERROR = 3 };

/* The only FMU of this process. */
typedef struct {
    m4e_channel *channel;
    uint32_t seen; /* the last request */
    long process;  /* that began to serve */
    void *component;
    unsigned char *request, *answer; /* arrays that do not fit into the channel, or NULL */
    uint64_t number[4];              /* of the call, */
    const unsigned char *at;         /* and its arrays */
    int32_t eager;
} m4e_remote_server;
extern m4e_remote_server m4e_serving;

/* How a function is called: `size` is that of a value in bytes. */
typedef struct {
    int (*perform)(void (*function)(void), size_t size);
    size_t size;
} m4e_remote_shape;
extern const m4e_remote_shape M4E_REMOTE_SHAPES[];

int m4e_remote_is_step(uint32_t function); /* 1: and it has ended without an event */
void m4e_remote_log(void *environment, const char *name, int status, const char *category,
                    const char *message, ...);
void m4e_remote_log_3(void *environment, int status, const char *category, const char *text);

#endif
