/* Runs a native FMU of FMI 3.0 and prints every bit of what it answers, on Linux and on Windows:
   fmu3_host LIBRARY RESOURCES TOKEN ALL N INPUTS N OUTPUTS N STEPS H, where each list is of value
   references with commas, and the number N behind it that of their scalars. At half of the run the state is kept, also as bytes; after its end it is restored twice, and the
   second half repeated. At the end, a directional and an adjoint derivative of all by the inputs. */
#include "fmi3Functions.h"
#include "host.h"

#define FUNCTIONS(X)                                                                              \
    X(fmi3InstantiateCoSimulation) X(fmi3EnterInitializationMode) X(fmi3ExitInitializationMode)   \
    X(fmi3GetFloat64) X(fmi3SetFloat64) X(fmi3DoStep) X(fmi3GetFMUState) X(fmi3SetFMUState)       \
    X(fmi3FreeFMUState) X(fmi3SerializedFMUStateSize) X(fmi3SerializeFMUState)                    \
    X(fmi3DeserializeFMUState) X(fmi3FreeInstance) X(fmi3GetDirectionalDerivative)                \
    X(fmi3GetAdjointDerivative)
#define DECLARED(name) static __typeof__(&name) do_##name;
FUNCTIONS(DECLARED)

typedef struct {
    fmi3ValueReference references[1000];
    size_t count, values;
} list;

static list all, inputs;
static double values[10000], given[10000], h;

static void told(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String text) {
    (void)e;
    printf("log %d %s %s\n", (int)status, category, text);
}

static void read_list(list *l, char *references, const char *scalars) {
    for (char *word = strtok(references, ","); word && l->count < 1000; word = strtok(NULL, ","))
        l->references[l->count++] = (fmi3ValueReference)strtoul(word, NULL, 10);
    l->values = strtoul(scalars, NULL, 10);
}

static int run(fmi3Instance c, const char *what, int from, int to) {
    bool event, end, early;
    double reached;
    fmi3Status status = fmi3OK;
    for (int k = from; k < to && status == fmi3OK; ++k) {
        for (size_t i = 0; i < inputs.values; ++i) given[i] = input(k, (int)i);
        if (do_fmi3SetFloat64(c, inputs.references, inputs.count, given, inputs.values)) return 5;
        status = do_fmi3DoStep(c, h * k, h, true, &event, &end, &early, &reached);
        print("reached", k, (int)status, &reached, 1);
        const int read = (int)do_fmi3GetFloat64(c, all.references, all.count, values, all.values);
        print(what, k, read, values, all.values);
    }
    return 0;
}

static int derivatives(fmi3Instance c, list *outputs) {
    for (size_t i = 0; i < inputs.values; ++i) given[i] = input(1, (int)i);
    int how = (int)do_fmi3GetDirectionalDerivative(c, outputs->references, outputs->count,
                                                   inputs.references, inputs.count, given,
                                                   inputs.values, values, outputs->values);
    print("directional", 0, how, values, outputs->values);
    for (size_t i = 0; i < outputs->values; ++i) given[i] = input(2, (int)i);
    how = (int)do_fmi3GetAdjointDerivative(c, outputs->references, outputs->count,
                                           inputs.references, inputs.count, given, outputs->values,
                                           values, inputs.values);
    print("adjoint", 0, how, values, inputs.values);
    return how;
}

int main(int count, char **words) {
    static list outputs;
    void *library = count == 12 ? opened(words[1]) : NULL;
    if (!library) return 2;
#define FOUND(name) do_##name = (__typeof__(&name))found(library, #name);
    FUNCTIONS(FOUND)
    read_list(&all, words[4], words[5]);
    read_list(&inputs, words[6], words[7]);
    read_list(&outputs, words[8], words[9]);
    const int steps = atoi(words[10]);
    h = atof(words[11]);
    fmi3Instance c = do_fmi3InstantiateCoSimulation("host", words[3], words[2], false, true, false,
                                                    false, NULL, 0, NULL, told, NULL);
    if (!c || do_fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0)) return 3;
    if (do_fmi3ExitInitializationMode(c)) return 3;
    fmi3FMUState kept = NULL, copy = NULL;
    size_t size = 0;
    if (run(c, "first", 0, steps / 2) || do_fmi3GetFMUState(c, &kept)) return 4;
    if (do_fmi3SerializedFMUStateSize(c, kept, &size)) return 4;
    fmi3Byte *bytes = malloc(size);
    if (do_fmi3SerializeFMUState(c, kept, bytes, size)) return 4;
    print_bytes(bytes, size);
    if (run(c, "second", steps / 2, steps)) return 4;
    if (do_fmi3SetFMUState(c, kept) || run(c, "second", steps / 2, steps)) return 4;
    if (do_fmi3DeserializeFMUState(c, bytes, size, &copy) || do_fmi3SetFMUState(c, copy)) return 4;
    if (run(c, "second", steps / 2, steps) || derivatives(c, &outputs)) return 4;
    if (do_fmi3FreeFMUState(c, &kept) || do_fmi3FreeFMUState(c, &copy)) return 4;
    free(bytes);
    do_fmi3FreeInstance(c);
    return 0;
}
