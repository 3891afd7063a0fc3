/* Files of an FMU's resources. */
#ifndef M4E_FILES_H
#define M4E_FILES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

/* The path that a file URI names, percent-encoding resolved, with `file` appended; a plain path is
   taken as it is. NULL where memory is short. */
char *files_path(const char *uri, const char *file);
/* Content of a file and a zero byte; NULL where it cannot be read. */
uint8_t *files_read(const char *path, size_t *size);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
