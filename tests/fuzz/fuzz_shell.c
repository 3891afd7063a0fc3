/* FMUs whose resources are damaged: none may crash, leak or run away (run this under sanitizers).

   fuzz_shell FIRST LAST SEED FOLDER2 FOLDER3 TOKEN2 TOKEN3: cases FIRST to LAST - 1, each by itself
   for its number and SEED. A file of the resources of an FMU of FMI 2.0 or 3.0 in a folder (which
   ends in a slash) is damaged, then the FMU is instantiated, stepped, saved, restored and freed.
   Prints how many cases there were, and how many FMUs could be instantiated. A case that takes more
   than LONGEST seconds of processor time ends the process, which prints its number. */
#include <math.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "mutate.h"

enum { FILES = 6, ROOM = 1 << 20, REFERENCES = 24, LONGEST = 20 };
static const char *const names[FILES] = {"model.m4e",      "model.m4e",     "model.m4e",
                                         "tangent.m4e",    "fmu.txt",       "model.m4e"};
static unsigned long number, accepted;

static void tell_case(int signal) {
    char text[] = "case                     takes too long\n";
    unsigned long rest = number;
    for (int i = 24; i > 4 && (rest || i == 24); --i, rest /= 10) text[i] = (char)('0' + rest % 10);
    if (write(2, text, sizeof text - 1) < 0) _exit(4);
    _exit(3);
    (void)signal;
}

static void logger2(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status,
                    fmi2String category, fmi2String message, ...) {
    (void)e, (void)status, (void)category;
    if (!name || !*message) abort();
}

static void logger3(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category,
                    fmi3String message) {
    (void)e, (void)status, (void)category;
    if (!*message) abort();
}

static void use2(const char *resources, const char *token) {
    const fmi2CallbackFunctions callbacks = {logger2, calloc, free, NULL, NULL};
    const double size = 0.01;
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, token, resources, &callbacks, 0, 1);
    if (!c) return;
    ++accepted;
    fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    double v[2] = {0.5, 1.0};
    fmi2FMUstate kept = NULL, again = NULL;
    for (fmi2ValueReference r = 0; r < REFERENCES; ++r) {
        fmi2ValueReference other = next(REFERENCES);
        fmi2GetReal(c, &r, 1, v);
        if (next(2)) fmi2SetReal(c, &r, 1, v);
        fmi2GetDirectionalDerivative(c, &r, 1, &other, 1, v, v + 1);
    }
    for (int i = 0; i < 2; ++i) fmi2DoStep(c, i * size, size, 1);
    size_t bytes = 0;
    if (fmi2GetFMUstate(c, &kept) == fmi2OK &&
        fmi2SerializedFMUstateSize(c, kept, &bytes) == fmi2OK && bytes < ROOM) {
        fmi2Byte *written = malloc(bytes + 1);
        if (written && fmi2SerializeFMUstate(c, kept, written, bytes) == fmi2OK) {
            if (next(2)) bytes = mutate((uint8_t *)written, bytes, bytes);
            fmi2DeSerializeFMUstate(c, written, bytes, &again);
        }
        free(written);
        fmi2SetFMUstate(c, again ? again : kept);
        fmi2DoStep(c, 2 * size, size, 1);
    }
    fmi2FreeFMUstate(c, &kept);
    fmi2FreeFMUstate(c, &again);
    fmi2Terminate(c);
    fmi2FreeInstance(c);
}

static void use3(const char *resources, const char *token) {
    const double size = 0.01;
    fmi3Instance c = fmi3InstantiateCoSimulation("one", token, resources, 0, 1, 0, 0, NULL, 0, NULL,
                                                 logger3, NULL);
    if (!c) return;
    ++accepted;
    fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0);
    fmi3ExitInitializationMode(c);
    double v[8] = {0.5, 1.0};
    fmi3FMUState kept = NULL, again = NULL;
    for (fmi3ValueReference r = 0; r < REFERENCES; ++r) {
        const size_t count = 1 + next(4);
        fmi3GetFloat64(c, &r, 1, v, count);
        if (next(2)) fmi3SetFloat64(c, &r, 1, v, count);
        size_t found = 0;
        fmi3GetNumberOfVariableDependencies(c, r, &found);
    }
    fmi3Boolean event, stop, early;
    double last;
    for (int i = 0; i < 2; ++i) fmi3DoStep(c, i * size, size, 1, &event, &stop, &early, &last);
    size_t bytes = 0;
    if (fmi3GetFMUState(c, &kept) == fmi3OK &&
        fmi3SerializedFMUStateSize(c, kept, &bytes) == fmi3OK && bytes < ROOM) {
        fmi3Byte *written = malloc(bytes + 1);
        if (written && fmi3SerializeFMUState(c, kept, written, bytes) == fmi3OK) {
            if (next(2)) bytes = mutate(written, bytes, bytes);
            fmi3DeserializeFMUState(c, written, bytes, &again);
        }
        free(written);
        fmi3SetFMUState(c, again ? again : kept);
        fmi3DoStep(c, 2 * size, size, 1, &event, &stop, &early, &last);
    }
    fmi3FreeFMUState(c, &kept);
    fmi3FreeFMUState(c, &again);
    fmi3Terminate(c);
    fmi3FreeInstance(c);
}

static size_t read_file(const char *path, uint8_t *data) {
    FILE *file = fopen(path, "rb");
    if (!file) return 0;
    const size_t size = fread(data, 1, ROOM / 2, file);
    fclose(file);
    return size;
}

static void write_file(const char *path, const uint8_t *data, size_t size) {
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) abort();
}

static void one_case(const char *folder, const char *token, int version) {
    static uint8_t seed[ROOM], data[ROOM];
    char path[512];
    const char *name = names[next(FILES)];
    snprintf(path, sizeof path, "%s%s", folder, name);
    const size_t size = read_file(path, seed);
    memcpy(data, seed, size);
    size_t mutated = mutate(data, size, ROOM);
    if (strstr(name, ".m4e") && next(8) > 0 && mutated >= 64) repair(data, mutated);
    if (strstr(name, ".txt") && next(2) && mutated > 0) /* a digit for another */
        data[next((uint32_t)mutated)] = (uint8_t) "0123456789 \n"[next(12)];
    if (size) write_file(path, data, mutated);
    (version == 2 ? use2 : use3)(folder, token);
    if (size) write_file(path, seed, size);
}

int main(int count, char **words) {
    if (count != 8) return 2;
    const unsigned long first = strtoul(words[1], NULL, 10), last = strtoul(words[2], NULL, 10);
    const uint64_t seed = strtoull(words[3], NULL, 10);
    signal(SIGPROF, tell_case);
    for (number = first; number < last; ++number) {
        const struct itimerval limit = {{0, 0}, {LONGEST, 0}};
        setitimer(ITIMER_PROF, &limit, NULL);
        state = (seed * UINT64_C(1000003) + number + 1) * UINT64_C(0x9e3779b97f4a7c15) | 1;
        for (int i = 0; i < 4; ++i) next(2);
        const int three = (int)(number & 1);
        one_case(words[4 + three], words[6 + three], 2 + three);
    }
    printf("%lu cases, %lu instances\n", last - first, accepted);
    return 0;
}
