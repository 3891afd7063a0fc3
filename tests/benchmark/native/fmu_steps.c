/* CPU time of a step of an FMU from C: fmu_steps LIBRARY RESOURCES GUID STEPS, in seconds. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"

static void silent(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c,
                   fmi2String m, ...) {
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

int main(int count, char **words) {
    void *library = count == 5 ? dlopen(words[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library) return 2;
#define FOUND(name) __typeof__(&name) do_##name = (__typeof__(&name))dlsym(library, #name)
    FOUND(fmi2Instantiate);
    FOUND(fmi2EnterInitializationMode);
    FOUND(fmi2ExitInitializationMode);
    FOUND(fmi2DoStep);
    FOUND(fmi2FreeInstance);
    const fmi2CallbackFunctions callbacks = {silent, calloc, free, NULL, NULL};
    const int steps = atoi(words[4]);
    double best = 1e9;
    for (int run = 0; run < 100; ++run) {
        fmi2Component c =
            do_fmi2Instantiate("c", fmi2CoSimulation, words[3], words[2], &callbacks, 0, 0);
        if (!c || do_fmi2EnterInitializationMode(c) || do_fmi2ExitInitializationMode(c)) return 3;
        const clock_t began = clock();
        for (int i = 0; i < steps; ++i)
            if (do_fmi2DoStep(c, 1e-3 * i, 1e-3, 1)) return 4;
        const double spent = (double)(clock() - began) / CLOCKS_PER_SEC / steps;
        if (spent < best) best = spent;
        do_fmi2FreeInstance(c);
    }
    printf("%.4g\n", best);
    return 0;
}
