/* Files of an FMU's resources. */
#include "files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* What follows the scheme and the host: file:/p, file:///p and file://localhost/p are all /p. */
static const char *without_scheme(const char *uri) {
    if (strncmp(uri, "file:", 5) != 0) return uri;
    uri += 5;
    if (strncmp(uri, "//", 2) == 0) {
        const char *path = strchr(uri + 2, '/');
        uri = path ? path : uri + 2;
    }
#ifdef _WIN32
    if (uri[0] == '/' && uri[1] != 0 && uri[2] == ':') ++uri; /* /C:/p */
#endif
    return uri;
}

char *files_path(const char *uri, const char *file) {
    const int encoded = strncmp(uri, "file:", 5) == 0;
    char *path = malloc(strlen(uri) + strlen(file) + 2), *end = path;
    if (!path) return NULL;
    for (uri = without_scheme(uri); *uri; ++uri) {
        const int high = encoded && *uri == '%' ? digit(uri[1]) : -1;
        const int low = high >= 0 ? digit(uri[2]) : -1;
        if (low >= 0) {
            *end++ = (char)(16 * high + low);
            uri += 2;
        } else {
            *end++ = *uri;
        }
    }
    if (end > path && end[-1] != '/') *end++ = '/';
    memcpy(end, file, strlen(file) + 1);
    return path;
}

uint8_t *files_read(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    long end = -1;
    if (file && fseek(file, 0, SEEK_END) == 0) end = ftell(file);
    if (end >= 0 && end < (1L << 30) && fseek(file, 0, SEEK_SET) == 0)
        bytes = malloc((size_t)end + 1);
    if (bytes) {
        *size = fread(bytes, 1, (size_t)end, file);
        bytes[*size] = 0;
    }
    if (file) fclose(file);
    return bytes;
}
