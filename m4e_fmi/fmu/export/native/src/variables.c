/* Variables: values read and set, one by one or as the vector of continuous states. */
#include <math.h>
#include <string.h>

#include "instance.h"

answer not_finite(instance *c, uint32_t scalar, double value) {
    const char *what = value != value ? "nan" : value > 0 ? "inf" : "-inf"; /* on every system */
    return tell(c, FMI_DISCARD, "%s is %s at t = %.9g s", name_of(c, scalar), what, c->now.t);
}

static double value_of(const instance *c, uint32_t s) {
    if (s < first_output(c)) return c->values[s];
    return s < scalars(c) ? c->y[s - first_output(c)] : c->now.t;
}

answer get_values(instance *c, const uint32_t references[], size_t count, double values[],
                  size_t room) {
    const uint32_t *s = scalars_of(c, references, count, room, 0);
    if (!s) return FMI_ERROR;
    CHECK(values || room == 0, "%s: there is nowhere to put values", c->function);
    refresh(c);
    answer how = FMI_OK;
    for (size_t i = 0; i < room; ++i) {
        values[i] = value_of(c, s[i]);
        if (!isfinite(values[i]) && how == FMI_OK) how = not_finite(c, s[i], values[i]);
    }
    return how;
}

/* Why a scalar cannot be set now, NULL if it can. */
static const char *refusal(const instance *c, uint32_t s) {
    const int starting = (c->now.phase & (INSTANTIATED | INITIALIZATION)) != 0;
    if (s < c->n.parameters) {
        const int tunable = (m4e_program_flags(c->program)[s] & M4E_TUNABLE) != 0;
        if (starting || (tunable && (c->now.phase & (EVENT | STEP)))) return NULL;
        return tunable ? "is changed at events and between steps only"
                       : "is fixed after initialization";
    }
    if (s < first_state(c)) return NULL;
    if (s >= first_output(c)) return "is calculated";
    /* the standard has a function for all states at once, but CasADi sets them one by one */
    const int exchange = (c->now.phase & (EVENT | CONTINUOUS)) != 0;
    return starting || exchange ? NULL : "is a state, set before the start only";
}

static void set_value(instance *c, uint32_t s, double value) {
    if (value != value_of(c, s)) c->now.held = 0;
    if (s < first_input(c)) c->stale_parameters = c->stale_tangent = 1;
    if (s >= first_input(c) && s < first_state(c)) c->stale_inputs = 1;
    c->values[s] = value;
    c->stale = 1;
}

answer set_values(instance *c, const uint32_t references[], size_t count, const double values[],
                  size_t given) {
    const uint32_t *s = scalars_of(c, references, count, given, 0);
    if (!s) return FMI_ERROR;
    CHECK(values || given == 0, "%s: no values are given", c->function);
    for (size_t i = 0; i < given; ++i) {
        const char *why = refusal(c, s[i]);
        CHECK(!why, "%s %s", name_of(c, s[i]), why);
        CHECK(isfinite(values[i]), "%s was set to %g", name_of(c, s[i]), values[i]);
        const m4e_limits *l = limits_of(c, s[i]);
        CHECK(values[i] >= l->minimum && values[i] <= l->maximum,
              "%s was set to %g, outside its range from %g to %g", name_of(c, s[i]), values[i],
              l->minimum, l->maximum);
    }
    for (size_t i = 0; i < given; ++i) set_value(c, s[i], values[i]);
    return FMI_OK;
}

/* The only variable that is not Real: the text of the last error. */
answer get_text(instance *c, const uint32_t references[], size_t count, const char *values[],
                size_t room) {
    CHECK((references && values) || count == 0, "%s: no value references are given", c->function);
    CHECK(room == count, "%s: room for %zu values is given, but they are %zu", c->function, room,
          count);
    for (size_t i = 0; i < count; ++i) {
        CHECK(references[i] == text_reference(c), "there is no String with value reference %u",
              references[i]);
        values[i] = c->last_error;
    }
    return FMI_OK;
}

answer set_time(instance *c, double t) {
    CHECK(isfinite(t), "%s: the time must be finite, got %g", c->function, t);
    c->now.t = t;
    c->stale = 1;
    return FMI_OK;
}

#define CHECK_STATES(values, count)                                                               \
    CHECK((count) == c->n.states && ((values) || (count) == 0),                                   \
          "there are %u continuous states, not %zu", c->n.states, count)

answer set_states(instance *c, const double x[], size_t count) {
    CHECK_STATES(x, count);
    for (size_t k = 0; k < count; ++k)
        if (!isfinite(x[k])) return not_finite(c, first_state(c) + (uint32_t)k, x[k]);
    for (size_t k = 0; k < count; ++k) c->x[k] = x[k];
    c->stale = 1;
    return FMI_OK;
}

answer get_states(instance *c, double x[], size_t count) {
    CHECK_STATES(x, count);
    for (size_t k = 0; k < count; ++k) x[k] = c->x[k];
    return FMI_OK;
}

answer get_rates(instance *c, double rates[], size_t count) {
    CHECK_STATES(rates, count);
    prepare(c);
    m4e_rates(c->model, c->now.t, c->x, c->rates);
    for (size_t k = 0; k < count; ++k) {
        rates[k] = c->rates[k];
        if (!isfinite(rates[k]))
            return tell(c, FMI_DISCARD, "the rate of %s is %g at t = %.9g s",
                        name_of(c, first_state(c) + (uint32_t)k), rates[k], c->now.t);
    }
    return FMI_OK;
}

answer get_nominals(instance *c, double nominals[], size_t count) {
    CHECK_STATES(nominals, count);
    for (size_t k = 0; k < count; ++k)
        nominals[k] = limits_of(c, first_state(c) + (uint32_t)k)->nominal;
    return FMI_OK;
}
