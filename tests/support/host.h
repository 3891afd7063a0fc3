/* What the programs share that run an FMU here and on Windows: its library, and bits printed. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *opened(const char *path) { return (void *)LoadLibraryA(path); }
static void *found(void *library, const char *name) {
    return (void *)GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *opened(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *found(void *library, const char *name) { return dlsym(library, name); }
#endif

static double input(int step, int i) { return 0.125 * (double)((7 * step + 3 * i) % 11 - 5) + 1.0; }

/* What, step, status, values. */
static void print(const char *what, int step, int status, const double *values, size_t n) {
    printf("%s %d %d", what, step, status);
    for (size_t i = 0; i < n; ++i) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        printf(" %016" PRIx64, bits);
    }
    printf("\n");
}

static void print_bytes(const void *bytes, size_t size) {
    printf("state ");
    for (size_t i = 0; i < size; ++i) printf("%02x", (unsigned)((const unsigned char *)bytes)[i]);
    printf("\n");
}
