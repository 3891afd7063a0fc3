/* Files of an FMU's resources. */
#include "instance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#endif

static int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* What follows the scheme: file:/p, file:///p and file://localhost/p are all /p; file:////p, which
   some importers write, is //p. On Windows the name of another machine stays, as //machine/p, and a
   drive has no slash before it. */
static const char *without_scheme(const char *uri) {
    static const char HERE[] = "//localhost/";
    if (strncmp(uri, "file:", 5) != 0) return uri;
    uri += 5;
    if (strncmp(uri, HERE, sizeof HERE - 1) == 0)
        uri += sizeof HERE - 2;
    else if (strncmp(uri, "///", 3) == 0)
        uri += 2;
#ifdef _WIN32
    if (uri[0] == '/' && uri[1] != 0 && uri[2] == ':') ++uri; /* /C:/p */
#else
    else if (strncmp(uri, "//", 2) == 0 && strchr(uri + 2, '/'))
        uri = strchr(uri + 2, '/');
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

#ifdef _WIN32
/* The path is UTF-8, as in URIs; a plain one may be in the code page of the system. */
static FILE *opened(const char *path) {
    UINT page = CP_UTF8;
    int length = MultiByteToWideChar(page, MB_ERR_INVALID_CHARS, path, -1, NULL, 0);
    if (length == 0) length = MultiByteToWideChar(page = CP_ACP, 0, path, -1, NULL, 0);
    wchar_t *wide = malloc(((size_t)length + 1) * sizeof *wide);
    FILE *file = NULL;
    if (wide && MultiByteToWideChar(page, 0, path, -1, wide, length) > 0)
        file = _wfopen(wide, L"rb");
    free(wide);
    return file;
}
#else
static FILE *opened(const char *path) { return fopen(path, "rb"); }
#endif

uint8_t *files_read(const char *path, size_t *size) {
    FILE *file = opened(path);
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
