/* FMI 2.0: phases, variables and derivatives, model exchange, co-simulation.

   A call that is refused answers fmi2Error with a text and changes nothing. Where the equations
   have no finite value the answer is fmi2Discard: a smaller step, or other inputs, may help. */
#include <math.h>
#include <string.h>

#include "instance.h"

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

/* ---- phases ---- */

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerant, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stops, fmi2Real stop) {
    ENTER(INSTANTIATED);
    CHECK(isfinite(start), "the start time must be finite, got %g", start);
    CHECK(!stops || stop >= start, "the stop time %g s is before the start time %g s", stop, start);
    CHECK(!tolerant || (tolerance > 0.0 && isfinite(tolerance)),
          "the tolerance must be positive, got %g", tolerance);
    c->now.t = start;
    c->now.stops = stops != 0;
    c->now.stop = stops ? stop : INFINITY;
    if (tolerant) c->now.tolerance = tolerance;
    c->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
    ENTER(INSTANTIATED);
    c->now.phase = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    ENTER(INITIALIZATION);
    c->now.phase = c->now.type == fmi2CoSimulation ? STEP : EVENT;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component) {
    ENTER(EVENT | CONTINUOUS | STEP | FAILED);
    c->now.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component component) {
    ENTER(ANY);
    to_start(c);
    c->last_error[0] = 0;
    return fmi2OK;
}

/* ---- variables ---- */

static fmi2Status not_finite(instance *c, uint32_t reference, double value) {
    const char *what = value != value ? "nan" : value > 0 ? "inf" : "-inf"; /* on every system */
    return tell(c, fmi2Discard, "%s is %s at t = %.9g s", name_of(c, reference), what, c->now.t);
}

static double value_of(const instance *c, uint32_t r) {
    if (r < c->n.parameters) return c->p[r];
    if (r < first_input(c)) return c->calculated[r - c->n.parameters];
    if (r < first_state(c)) return c->u[r - first_input(c)];
    if (r < first_output(c)) return c->x[r - first_state(c)];
    return c->y[r - first_output(c)];
}

#define CHECK_REFERENCES(references, count)                                                       \
    CHECK((references) || (count) == 0, "%s: no value references are given", __func__);           \
    for (size_t i_ = 0; i_ < (count); ++i_)                                                       \
    CHECK((references)[i_] < reals(c), "%s: there is no Real with value reference %u", __func__,  \
          (references)[i_])

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[],
                       size_t count, fmi2Real values[]) {
    ENTER(READABLE);
    CHECK_REFERENCES(references, count);
    CHECK(values || count == 0, "fmi2GetReal: there is nowhere to put values");
    refresh(c);
    fmi2Status how = fmi2OK;
    for (size_t i = 0; i < count; ++i) {
        values[i] = value_of(c, references[i]);
        if (!isfinite(values[i]) && how == fmi2OK) how = not_finite(c, references[i], values[i]);
    }
    return how;
}

/* Why a variable cannot be set now, NULL if it can. */
static const char *refusal(const instance *c, uint32_t r) {
    const int starting = (c->now.phase & (INSTANTIATED | INITIALIZATION)) != 0;
    if (r < c->n.parameters) {
        const int tunable = (m4e_program_flags(c->program)[r] & M4E_TUNABLE) != 0;
        if (starting || (tunable && c->now.phase != CONTINUOUS)) return NULL;
        return tunable ? "is changed at events only" : "is fixed after initialization";
    }
    if (r < first_input(c)) return "is calculated";
    if (r < first_state(c)) return NULL;
    if (r >= first_output(c)) return "is calculated";
    /* the standard has fmi2SetContinuousStates for this, but CasADi sets them one by one */
    const int exchange = (c->now.phase & (EVENT | CONTINUOUS)) != 0;
    return starting || exchange ? NULL : "is a state, set before the start only";
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[],
                       size_t count, const fmi2Real values[]) {
    ENTER(SETTABLE);
    CHECK_REFERENCES(references, count);
    CHECK(values || count == 0, "fmi2SetReal: no values are given");
    for (size_t i = 0; i < count; ++i) {
        const char *why = refusal(c, references[i]);
        CHECK(!why, "%s %s", name_of(c, references[i]), why);
        CHECK(isfinite(values[i]), "%s was set to %g", name_of(c, references[i]), values[i]);
    }
    for (size_t i = 0; i < count; ++i) {
        const uint32_t r = references[i];
        if (r < c->n.parameters) {
            c->p[r] = values[i];
            c->stale_parameters = c->stale_tangent = 1;
        } else if (r < first_state(c)) {
            c->u[r - first_input(c)] = values[i];
        } else {
            c->x[r - first_state(c)] = values[i];
        }
        c->stale = 1;
    }
    return fmi2OK;
}

/* The only variable that is not Real: the text of the last error. */
fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[],
                         size_t count, fmi2String values[]) {
    ENTER(READABLE);
    CHECK((references && values) || count == 0, "fmi2GetString: no value references are given");
    for (size_t i = 0; i < count; ++i) {
        CHECK(references[i] == 0, "there is no String with value reference %u", references[i]);
        values[i] = c->last_error;
    }
    return fmi2OK;
}

#define REFUSED(Verb, Type, Const)                                                                \
    fmi2Status fmi2##Verb##Type(fmi2Component component, const fmi2ValueReference references[],   \
                                size_t count, Const fmi2##Type values[]) {                        \
        ENTER(ANY);                                                                               \
        (void)references;                                                                         \
        (void)values;                                                                             \
        CHECK(count == 0, "there is no " #Type " variable for fmi2" #Verb #Type);                 \
        return fmi2OK;                                                                            \
    }
REFUSED(Get, Integer, )
REFUSED(Get, Boolean, )
REFUSED(Set, Integer, const)
REFUSED(Set, Boolean, const)
REFUSED(Set, String, const)

/* ---- derivatives ---- */

/* Place in the tangent's direction for a change of a variable; 0 where it cannot be a direction.
   The direction: inputs, change of time, of states, of inputs, of parameters. */
static size_t direction_of(const instance *c, uint32_t r) {
    const size_t states = (size_t)c->n.inputs + 1, inputs = states + c->n.states;
    if (r < c->n.parameters) return inputs + c->n.inputs + r;
    if (r < first_input(c)) return 0;
    if (r < first_state(c)) return inputs + (r - first_input(c));
    return r < first_output(c) ? states + (r - first_state(c)) : 0;
}

/* Change of a variable that is calculated or a state, after `differentiate`. */
static double change_of(const instance *c, uint32_t r) {
    if (r >= first_output(c)) return c->changes[r - first_output(c)];
    if (r < first_input(c)) return c->changes[c->n.outputs + (r - c->n.parameters)];
    return c->direction[direction_of(c, r)];
}

static void clear_direction(instance *c) {
    const size_t count = (size_t)c->n.inputs + 1 + c->n.states + c->n.parameters;
    memset(c->direction + c->n.inputs, 0, count * sizeof *c->direction);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component,
                                        const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns,
                                        const fmi2Real seed[], fmi2Real result[]) {
    ENTER(READABLE);
    CHECK_REFERENCES(unknown, unknowns);
    CHECK_REFERENCES(known, knowns);
    CHECK((seed || knowns == 0) && (result || unknowns == 0),
          "fmi2GetDirectionalDerivative: no seed or no room for the result is given");
    for (size_t i = 0; i < unknowns; ++i) {
        const uint32_t r = unknown[i];
        CHECK(r >= first_state(c) || (r >= c->n.parameters && r < first_input(c)),
              "fmi2GetDirectionalDerivative: %s is no unknown", name_of(c, r));
    }
    for (size_t i = 0; i < knowns; ++i)
        CHECK(direction_of(c, known[i]) > 0, "fmi2GetDirectionalDerivative: %s is no known",
              name_of(c, known[i]));
    if (!have_tangent(c)) return fmi2Error;
    clear_direction(c);
    for (size_t i = 0; i < knowns; ++i) c->direction[direction_of(c, known[i])] += seed[i];
    differentiate(c);
    fmi2Status how = fmi2OK;
    for (size_t i = 0; i < unknowns; ++i) {
        result[i] = change_of(c, unknown[i]);
        if (!isfinite(result[i]) && how == fmi2OK)
            how = tell(c, fmi2Discard, "the derivative of %s is %g at t = %.9g s",
                       name_of(c, unknown[i]), result[i], c->now.t);
    }
    return how;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component,
                                        const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer order[], fmi2Real values[]) {
    ENTER(STEP | FAILED | TERMINATED);
    CHECK_REFERENCES(references, count);
    CHECK((order && values) || count == 0, "fmi2GetRealOutputDerivatives: no orders are given");
    for (size_t i = 0; i < count; ++i) {
        CHECK(order[i] == 1, "output derivatives are of order 1, not %d", order[i]);
        CHECK(references[i] >= first_state(c), "%s is no output", name_of(c, references[i]));
    }
    CHECK(c->now.type == fmi2CoSimulation, "output derivatives belong to co-simulation");
    if (!have_tangent(c)) return fmi2Error;
    clear_direction(c);
    prepare(c);
    double *direction = c->direction + c->n.inputs;
    direction[0] = 1.0;
    m4e_rates(c->model, c->now.t, c->x, direction + 1);
    if (c->n.inputs)
        memcpy(direction + 1 + c->n.states, c->first, c->n.inputs * sizeof *c->first);
    differentiate(c);
    fmi2Status how = fmi2OK;
    for (size_t i = 0; i < count; ++i) {
        values[i] = change_of(c, references[i]);
        if (!isfinite(values[i]) && how == fmi2OK) how = not_finite(c, references[i], values[i]);
    }
    return how;
}

/* ---- model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component component) {
    ENTER(EVENT | CONTINUOUS);
    c->now.phase = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info) {
    ENTER(EVENT);
    CHECK(info, "fmi2NewDiscreteStates: there is nowhere to put the answer");
    *info = (fmi2EventInfo){0};
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component) {
    ENTER(EVENT);
    c->now.phase = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component component, fmi2Boolean no_return,
                                       fmi2Boolean *event, fmi2Boolean *terminate) {
    ENTER(CONTINUOUS);
    (void)no_return;
    CHECK(event && terminate, "fmi2CompletedIntegratorStep: there is nowhere to put the answer");
    *event = *terminate = 0;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real t) {
    ENTER(EVENT | CONTINUOUS);
    CHECK(isfinite(t), "fmi2SetTime: the time must be finite, got %g", t);
    c->now.t = t;
    c->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real x[], size_t count) {
    ENTER(CONTINUOUS);
    CHECK(count == c->n.states && (x || count == 0), "there are %u continuous states, not %zu",
          c->n.states, count);
    for (uint32_t i = 0; i < count; ++i)
        if (!isfinite(x[i])) return not_finite(c, first_state(c) + i, x[i]);
    if (count) memcpy(c->x, x, count * sizeof *x);
    c->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real x[], size_t count) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    CHECK(count == c->n.states && (x || count == 0), "there are %u continuous states, not %zu",
          c->n.states, count);
    if (count) memcpy(x, c->x, count * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real rates[], size_t count) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    CHECK(count == c->n.states && (rates || count == 0), "there are %u continuous states, not %zu",
          c->n.states, count);
    prepare(c);
    m4e_rates(c->model, c->now.t, c->x, rates);
    for (uint32_t i = 0; i < count; ++i)
        if (!isfinite(rates[i]))
            return tell(c, fmi2Discard, "the rate of %s is %g at t = %.9g s",
                        name_of(c, first_state(c) + i), rates[i], c->now.t);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real nominals[],
                                             size_t count) {
    ENTER(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    CHECK(count == c->n.states && (nominals || count == 0),
          "there are %u continuous states, not %zu", c->n.states, count);
    for (size_t i = 0; i < count; ++i) nominals[i] = 1.0;
    return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real indicators[], size_t count) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    (void)indicators;
    CHECK(count == 0, "there are no event indicators");
    return fmi2OK;
}

/* ---- co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component,
                                       const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer order[], const fmi2Real values[]) {
    ENTER(INSTANTIATED | INITIALIZATION | STEP);
    CHECK(c->now.type == fmi2CoSimulation, "input derivatives belong to co-simulation");
    CHECK_REFERENCES(references, count);
    CHECK((order && values) || count == 0, "fmi2SetRealInputDerivatives: no orders are given");
    for (size_t i = 0; i < count; ++i) {
        const uint32_t r = references[i];
        CHECK(r >= first_input(c) && r < first_state(c), "%s is no input", name_of(c, r));
        CHECK(order[i] == 1 || order[i] == 2, "input derivatives are of order 1 or 2, not %d",
              order[i]);
        CHECK(isfinite(values[i]), "a derivative of %s was set to %g", name_of(c, r), values[i]);
    }
    if (count && c->now.curved != 1) memset(c->first, 0, 2 * c->n.inputs * sizeof *c->first);
    for (size_t i = 0; i < count; ++i)
        (order[i] == 1 ? c->first : c->second)[references[i] - first_input(c)] = values[i];
    if (count) c->now.curved = 1;
    return fmi2OK;
}

/* Inputs and their derivatives `h` later: the input has followed its curve. */
static void move_inputs(instance *c, double h) {
    for (uint32_t i = 0; i < c->n.inputs; ++i) {
        c->u[i] += h * (c->first[i] + 0.5 * h * c->second[i]);
        c->first[i] += h * c->second[i];
    }
    c->now.curved = 2;
}

static fmi2Status failure(instance *c, const m4e_report *report) {
    const char *why = "a state or its rate is not finite";
    if (report->status == M4E_SMALL_STEP) why = "the step size needed is too small to go on";
    if (report->status == M4E_MANY_STEPS) why = "too many steps are needed";
    if (report->component < 0) return tell(c, fmi2Discard, "%s at t = %.9g s", why, report->time);
    const char *name = name_of(c, first_state(c) + (uint32_t)report->component);
    return tell(c, fmi2Discard, "%s at t = %.9g s: %s", why, report->time, name);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
    ENTER(STEP);
    (void)no_return;
    CHECK(h > 0.0 && isfinite(t + h), "fmi2DoStep: no step from %g s over %g s", t, h);
    CHECK(fabs(t - c->now.t) <= 1e-6 * h + 1e-12 * fabs(t),
          "fmi2DoStep: a step from t = %.12g s, but the time is %.12g s", t, c->now.t);
    CHECK(!c->now.stops || t + h <= c->now.stop + 1e-6 * h + 1e-12 * fabs(t),
          "fmi2DoStep: a step to %.12g s, but the stop time is %.12g s", t + h, c->now.stop);
    if (!have_integrator(c)) return fmi2Error;
    if (c->now.curved == 2) { /* they held for the step before */
        memset(c->first, 0, 2 * c->n.inputs * sizeof *c->first);
        c->now.curved = 0;
    }
    prepare(c);
    if (c->now.curved) m4e_set_input_curves(c->model, t, c->u, c->first, c->second);
    m4e_report report;
    const double end = t + h;
    m4e_start(c->integrator, t, c->x, c->now.step);
    const int done = m4e_advance(c->integrator, end, 1, &end, c->x, &report) == M4E_DONE;
    if (!done) m4e_reached(c->integrator, c->x);
    c->now.t = done ? end : report.time;
    c->now.step = report.step;
    c->stale = 1;
    if (c->now.curved) move_inputs(c, c->now.t - t);
    if (done) return fmi2OK;
    c->now.phase = FAILED;
    return failure(c, &report);
}

fmi2Status fmi2CancelStep(fmi2Component component) {
    ENTER(0); /* a step is never still going on */
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
    ENTER(STEP | FAILED | TERMINATED);
    CHECK(value, "fmi2GetRealStatus: there is nowhere to put the answer");
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = c->now.t;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Boolean *value) {
    ENTER(STEP | FAILED | TERMINATED);
    CHECK(value, "fmi2GetBooleanStatus: there is nowhere to put the answer");
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = c->now.phase == FAILED; /* it cannot go on from there */
    return fmi2OK;
}

/* Of a step that is still going on. */
#define NO_STATUS(Name, Type)                                                                     \
    fmi2Status fmi2Get##Name(fmi2Component component, const fmi2StatusKind kind, Type *value) {   \
        ENTER(STEP | FAILED | TERMINATED);                                                        \
        (void)kind;                                                                               \
        (void)value;                                                                              \
        return tell(c, fmi2Discard, "fmi2Get" #Name ": no step is going on");                     \
    }
NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)
