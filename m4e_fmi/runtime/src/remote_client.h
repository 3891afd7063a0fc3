/* Calls by the shape of their arguments: remote_values.c has what remote_calls.c gives names to. */
#ifndef M4E_REMOTE_CLIENT_H
#define M4E_REMOTE_CLIENT_H

#include "remote.h"

#define COUNT(array) (int)(sizeof(array) / sizeof *(array))
#define ASK(function, given, wanted)                                                               \
    m4e_remote_ask(r, function, given, COUNT(given), wanted, COUNT(wanted))

typedef uint32_t vr;

/* Values may have come along with the last step, or not (`now`). */
int m4e_remote_get(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                   size_t values, void *to, size_t size);
int m4e_remote_get_now(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                       size_t values, void *to, size_t size);
int m4e_remote_set(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                   size_t values, const void *from, size_t size);
int m4e_remote_get_texts(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                     const char **values, size_t size);
int m4e_remote_set_texts(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                     const char *const *values, size_t size);
int m4e_remote_with_orders(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                       const int32_t *orders, const double *given_values, double *values,
                       size_t size);
int m4e_remote_derivative(m4e_remote *r, uint32_t function, const vr *unknowns,
                          size_t unknown_count, const vr *knowns, size_t known_count,
                          const double *seed, size_t seeds, double *found, size_t size);
int m4e_remote_step(m4e_remote *r, uint32_t function, double t, double h, int no_return);

#endif
