/* Runs a native FMU and prints every bit of what it answers, on Linux and on Windows:
   fmu_host LIBRARY RESOURCES GUID REALS FIRST INPUTS STEPS H, where the inputs are the Reals from
   FIRST on. Lines: what, step, status, values. At half of the run the state is kept, also as bytes;
   after its end it is restored twice, and the second half repeated. */
#include "fmi2Functions.h"
#include "host.h"

#define FUNCTIONS(X)                                                                              \
    X(fmi2Instantiate) X(fmi2SetupExperiment) X(fmi2EnterInitializationMode)                      \
    X(fmi2ExitInitializationMode) X(fmi2GetReal) X(fmi2SetReal) X(fmi2DoStep) X(fmi2GetFMUstate)  \
    X(fmi2SetFMUstate) X(fmi2FreeFMUstate) X(fmi2SerializedFMUstateSize) X(fmi2SerializeFMUstate) \
    X(fmi2DeSerializeFMUstate) X(fmi2GetRealStatus) X(fmi2FreeInstance) X(fmi2SetDebugLogging)
#define DECLARED(name) static __typeof__(&name) do_##name;
FUNCTIONS(DECLARED)

static void told(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
    (void)e;
    printf("log %s %d %s %s\n", name, (int)status, category, message);
}

static unsigned reals, first, inputs;
static int steps;
static double h;

static int run(fmi2Component c, const char *what, int from, int to) {
    fmi2ValueReference *all = malloc((reals + 1) * sizeof *all);
    double *values = calloc(reals + 1, sizeof *values), reached;
    for (unsigned i = 0; i < reals; ++i) all[i] = i;
    fmi2Status status = fmi2OK;
    for (int k = from; k < to && status == fmi2OK; ++k) {
        for (unsigned i = 0; i < inputs; ++i)
            values[i] = input(k, (int)i);
        if (do_fmi2SetReal(c, all + first, inputs, values)) return 5;
        status = do_fmi2DoStep(c, h * k, h, 1);
        if (status == fmi2Discard && do_fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &reached) == 0)
            print("reached", k, status, &reached, 1);
        const fmi2Status read = do_fmi2GetReal(c, all, reals, values);
        print(what, k, read, values, reals);
    }
    free(all);
    free(values);
    return 0;
}

int main(int count, char **words) {
    void *library = count == 9 ? opened(words[1]) : NULL;
    if (!library) return 2;
#define FOUND(name) do_##name = (__typeof__(&name))found(library, #name);
    FUNCTIONS(FOUND)
    reals = (unsigned)atoi(words[4]);
    first = (unsigned)atoi(words[5]);
    inputs = (unsigned)atoi(words[6]);
    steps = atoi(words[7]);
    h = atof(words[8]);
    const fmi2CallbackFunctions callbacks = {told, calloc, free, NULL, NULL};
    fmi2Component c =
        do_fmi2Instantiate("host", fmi2CoSimulation, words[3], words[2], &callbacks, 0, 1);
    if (!c || do_fmi2SetDebugLogging(c, 1, 0, NULL)) return 3;
    if (do_fmi2DoStep(c, 0.0, h, 1) != fmi2Error) return 3; /* tells why it is refused */
    if (do_fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0)) return 3;
    if (do_fmi2EnterInitializationMode(c) || do_fmi2ExitInitializationMode(c)) return 3;
    fmi2FMUstate kept = NULL, copy = NULL;
    size_t size = 0;
    if (run(c, "first", 0, steps / 2) || do_fmi2GetFMUstate(c, &kept)) return 4;
    if (do_fmi2SerializedFMUstateSize(c, kept, &size)) return 4;
    char *bytes = malloc(size);
    if (do_fmi2SerializeFMUstate(c, kept, bytes, size)) return 4;
    print_bytes(bytes, size);
    if (run(c, "second", steps / 2, steps)) return 4;
    if (do_fmi2SetFMUstate(c, kept) || run(c, "second", steps / 2, steps)) return 4;
    if (do_fmi2DeSerializeFMUstate(c, bytes, size, &copy) || do_fmi2SetFMUstate(c, copy)) return 4;
    if (run(c, "second", steps / 2, steps)) return 4;
    if (do_fmi2FreeFMUstate(c, &kept) || do_fmi2FreeFMUstate(c, &copy)) return 4;
    free(bytes);
    do_fmi2FreeInstance(c);
    return 0;
}
