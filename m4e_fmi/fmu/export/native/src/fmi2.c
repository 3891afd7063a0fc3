/* FMI 2.0: phases, variables and derivatives, model exchange, co-simulation.

   A call that is refused answers fmi2Error with a text and changes nothing. Where the equations
   have no finite value the answer is fmi2Discard: a smaller step, or other inputs, may help. */
#include "fmi2.h"

#include "instance.h"

#define ENTER(phases)                                                                             \
    instance *c = component;                                                                      \
    if (!allowed(c, phases, __func__)) return fmi2Error
#define NEEDS(condition, text)                                                                    \
    if (!(condition)) return (fmi2Status)tell(c, FMI_ERROR, "%s: " text, __func__)

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

/* ---- instances ---- */

typedef void message_logger(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String,
                            fmi2String, ...);

static void log_message(const instance *c, answer how, const char *category, const char *message) {
    char text[2 * sizeof c->last_error], *to = text; /* the logger takes it as a format */
    for (const char *from = message; *from; ++from) {
        if (*from == '%') *to++ = '%';
        *to++ = *from;
    }
    *to = 0;
    ((message_logger *)c->logger)(c->environment, c->name, (fmi2Status)how, category, text);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging_on) {
    (void)visible;
    if (!functions) return NULL;
    instance *c = instance_new(&(request){.name = name,
                                          .token = guid,
                                          .resources = resources,
                                          .type = (uint32_t)type,
                                          .environment = functions->componentEnvironment,
                                          .log = log_message,
                                          .logger = (callback *)functions->logger});
    if (c && logging_on) c->told = TOLD_ALL;
    return c;
}

void fmi2FreeInstance(fmi2Component component) { instance_free(component); }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                               const fmi2String categories[]) {
    ENTER(ANY);
    return (fmi2Status)set_logging(c, on, count, categories);
}

/* ---- phases ---- */

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerant, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stops, fmi2Real stop) {
    ENTER(INSTANTIATED);
    return (fmi2Status)set_experiment(c, tolerant, tolerance, start, stops, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
    ENTER(INSTANTIATED);
    c->now.phase = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    ENTER(INITIALIZATION);
    c->now.phase = c->now.type == CO_SIMULATION ? STEP : EVENT;
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

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[],
                       size_t count, fmi2Real values[]) {
    ENTER(READABLE);
    return (fmi2Status)get_values(c, references, count, values, count);
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[],
                       size_t count, const fmi2Real values[]) {
    ENTER(SETTABLE);
    return (fmi2Status)set_values(c, references, count, values, count);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[],
                         size_t count, fmi2String values[]) {
    ENTER(READABLE);
    return (fmi2Status)get_text(c, references, count, values, count);
}

#define REFUSED(Verb, Type, Const)                                                                \
    fmi2Status fmi2##Verb##Type(fmi2Component component, const fmi2ValueReference references[],   \
                                size_t count, Const fmi2##Type values[]) {                        \
        ENTER(ANY);                                                                               \
        (void)references;                                                                         \
        (void)values;                                                                             \
        NEEDS(count == 0, "there is no such " #Type);                                             \
        return fmi2OK;                                                                            \
    }
REFUSED(Get, Integer, )
REFUSED(Get, Boolean, )
REFUSED(Set, Integer, const)
REFUSED(Set, Boolean, const)
REFUSED(Set, String, const)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component,
                                        const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns,
                                        const fmi2Real seed[], fmi2Real result[]) {
    ENTER(READABLE);
    return (fmi2Status)directional_derivative(c, unknown, unknowns, known, knowns, seed, knowns,
                                              result, unknowns);
}

/* ---- states ---- */

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state) {
    ENTER(ANY);
    return (fmi2Status)keep_state(c, state);
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
    ENTER(ANY);
    return (fmi2Status)restore_state(c, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state) {
    ENTER(ANY);
    return (fmi2Status)free_state(c, state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size) {
    ENTER(ANY);
    return (fmi2Status)state_size(c, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size) {
    ENTER(ANY);
    return (fmi2Status)write_state(c, state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state) {
    ENTER(ANY);
    return (fmi2Status)read_state(c, bytes, size, state);
}

/* ---- model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component component) {
    ENTER(EVENT | CONTINUOUS);
    c->now.phase = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info) {
    ENTER(EVENT);
    NEEDS(info, "there is nowhere to put the answer");
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
    NEEDS(event && terminate, "there is nowhere to put the answer");
    *event = *terminate = 0;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real t) {
    ENTER(EVENT | CONTINUOUS);
    return (fmi2Status)set_time(c, t);
}

fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real x[], size_t count) {
    ENTER(CONTINUOUS);
    return (fmi2Status)set_states(c, x, count);
}

fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real x[], size_t count) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi2Status)get_states(c, x, count);
}

fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real rates[], size_t count) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi2Status)get_rates(c, rates, count);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real nominals[],
                                             size_t count) {
    ENTER(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi2Status)get_nominals(c, nominals, count);
}

fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real indicators[], size_t count) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    (void)indicators;
    NEEDS(count == 0, "there are no event indicators");
    return fmi2OK;
}

/* ---- co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component,
                                       const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer order[], const fmi2Real values[]) {
    ENTER(INSTANTIATED | INITIALIZATION | STEP);
    return (fmi2Status)set_input_derivatives(c, references, count, order, values);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component,
                                        const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer order[], fmi2Real values[]) {
    ENTER(STEP | FAILED | TERMINATED);
    return (fmi2Status)output_derivatives(c, references, count, order, values, count);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
    ENTER(STEP);
    (void)no_return;
    return (fmi2Status)do_step(c, t, h);
}

fmi2Status fmi2CancelStep(fmi2Component component) {
    ENTER(0); /* a step is never still going on */
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
    ENTER(STEP | FAILED | TERMINATED);
    NEEDS(value, "there is nowhere to put the answer");
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = c->now.t;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Boolean *value) {
    ENTER(STEP | FAILED | TERMINATED);
    NEEDS(value, "there is nowhere to put the answer");
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = 0; /* a step that failed is no wish to end the simulation */
    return fmi2OK;
}

/* Of a step that is still going on. */
#define NO_STATUS(Name, Type)                                                                     \
    fmi2Status fmi2Get##Name(fmi2Component component, const fmi2StatusKind kind, Type *value) {   \
        ENTER(STEP | FAILED | TERMINATED);                                                        \
        (void)kind;                                                                               \
        (void)value;                                                                              \
        return (fmi2Status)tell(c, FMI_DISCARD, "%s: no step is going on", __func__);             \
    }
NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)
