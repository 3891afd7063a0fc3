/* Components that feed the next one, written as one would for this system alone. */
#include "fmi2Functions.h"

typedef fmi2Status get_real(fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
typedef fmi2Status set_real(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Real[]);
typedef fmi2Status do_step(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);

int macro_loop(get_real *get, set_real *set, do_step *step, fmi2Component *c, int count, int closed,
               int size, const fmi2ValueReference *outputs, const fmi2ValueReference *inputs,
               double h, long begun, int steps) {
    double values[8];
    for (long i = begun; i < begun + steps; ++i) {
        for (int k = 0; k < count; ++k)
            if (step(c[k], (double)i * h, h, 1)) return 1;
        for (int k = 0; k < count - !closed; ++k) {
            get(c[k], outputs, (size_t)size, values);
            set(c[(k + 1) % count], inputs, (size_t)size, values);
        }
    }
    return 0;
}
