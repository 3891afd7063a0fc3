/* FMI 3.0: phases, variables and derivatives, model exchange, co-simulation.

   A call that is refused answers fmi3Error with a text and changes nothing, though the standard lets
   an importer count on less. What cannot be computed answers fmi3Discard, and the FMU is as it was
   before the call. There are neither clocks nor structural parameters nor events. */
#include <string.h>

#include "fmi3_calls.h"

enum { WITHIN = READABLE | INTERMEDIATE };

const char *fmi3GetVersion(void) { return "3.0"; }

/* ---- instances ---- */

static void log_message(const instance *c, answer how, const char *category, const char *message) {
    ((fmi3LogMessageCallback)c->logger)(c->environment, (fmi3Status)how, category, message);
}

static instance *made(const request *wanted, int logging_on) {
    instance *c = instance_new(wanted);
    if (c) c->told = logging_on ? TOLD_ALL : TOLD_NOTHING;
    return c;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging_on,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    (void)visible;
    return made(&(request){.name = name,
                           .token = token,
                           .resources = resources,
                           .layout = "variables.txt",
                           .type = MODEL_EXCHANGE,
                           .environment = environment,
                           .log = log_message,
                           .logger = (callback *)logger},
                logging_on);
}

/* Shows the importer a step of the integrator; answers where to stop. */
static double observe(instance *c, double end) {
    fmi3Boolean early = false;
    fmi3Float64 wanted = end;
    const fmi3Boolean may_return = c->may_return && c->now.t < end;
    ((fmi3IntermediateUpdateCallback)c->observer)(c->environment, c->now.t, true, true, true,
                                                  may_return, &early, &wanted);
    if (!may_return || !early || !(wanted < end)) return end;
    return wanted > c->now.t ? wanted : c->now.t;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging_on,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t count,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    (void)visible;
    instance *c = made(&(request){.name = name,
                                  .token = token,
                                  .resources = resources,
                                  .layout = "variables.txt",
                                  .type = CO_SIMULATION,
                                  .environment = environment,
                                  .log = log_message,
                                  .logger = (callback *)logger},
                       1);
    if (!c) return NULL;
    int sound = !events && (count == 0 || intermediate);
    for (size_t i = 0; sound && i < count; ++i) sound = intermediate[i] < c->layout.variables;
    if (!sound) {
        tell(c, FMI_ERROR, events ? "fmi3InstantiateCoSimulation: there is no event mode"
                                  : "fmi3InstantiateCoSimulation: an intermediate variable is none");
        instance_free(c);
        return NULL;
    }
    c->may_return = early;
    c->observer = (callback *)update;
    c->observe = update ? observe : NULL;
    c->told = logging_on ? TOLD_ALL : TOLD_NOTHING;
    return c;
}

void fmi3FreeInstance(fmi3Instance self) {
    instance *c = self;
    if (c && c->now.phase == INTERMEDIATE)
        allowed(c, ANY, __func__); /* fmi3DoStep still needs it */
    else
        instance_free(c);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance self, fmi3Boolean on, size_t count,
                               const fmi3String categories[]) {
    ENTER(ANY | INTERMEDIATE);
    return (fmi3Status)set_logging(c, on, count, categories);
}

/* ---- phases ---- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance self, fmi3Boolean tolerant,
                                       fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean stops,
                                       fmi3Float64 stop) {
    ENTER(INSTANTIATED);
    const answer how = set_experiment(c, tolerant, tolerance, start, stops, stop);
    if (how == FMI_OK) c->now.phase = INITIALIZATION;
    return (fmi3Status)how;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance self) {
    ENTER(INITIALIZATION);
    c->now.phase = c->now.type == CO_SIMULATION ? STEP : EVENT;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance self) {
    ENTER(CONTINUOUS);
    c->now.phase = EVENT;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance self) {
    ENTER(EVENT | CONTINUOUS | STEP);
    c->now.phase = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance self) {
    ENTER(ANY);
    to_start(c);
    c->last_error[0] = 0;
    return fmi3OK;
}

/* ---- variables ---- */

fmi3Status fmi3GetFloat64(fmi3Instance self, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t room) {
    ENTER(INSTANTIATED | WITHIN);
    return (fmi3Status)get_values(c, references, count, values, room);
}

fmi3Status fmi3SetFloat64(fmi3Instance self, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t given) {
    ENTER(SETTABLE | INTERMEDIATE);
    return (fmi3Status)set_values(c, references, count, values, given);
}

fmi3Status fmi3GetString(fmi3Instance self, const fmi3ValueReference references[], size_t count,
                         fmi3String values[], size_t room) {
    ENTER(INSTANTIATED | WITHIN);
    return (fmi3Status)get_text(c, references, count, values, room);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance self, const fmi3ValueReference unknowns[],
                                        size_t unknown_count, const fmi3ValueReference knowns[],
                                        size_t known_count, const fmi3Float64 seed[], size_t seeds,
                                        fmi3Float64 result[], size_t results) {
    ENTER(WITHIN);
    return (fmi3Status)directional_derivative(c, unknowns, unknown_count, knowns, known_count,
                                              seed, seeds, result, results);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance self, const fmi3ValueReference unknowns[],
                                    size_t unknown_count, const fmi3ValueReference knowns[],
                                    size_t known_count, const fmi3Float64 seed[], size_t seeds,
                                    fmi3Float64 result[], size_t results) {
    ENTER(WITHIN);
    return (fmi3Status)adjoint_derivative(c, unknowns, unknown_count, knowns, known_count, seed,
                                          seeds, result, results);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance self, fmi3ValueReference reference,
                                               size_t *count) {
    ENTER(ANY | INTERMEDIATE);
    NEEDS_ANSWERS(count);
    return (fmi3Status)count_dependencies(c, reference, count);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance self, fmi3ValueReference dependent,
                                       size_t dependent_elements[],
                                       fmi3ValueReference independents[],
                                       size_t independent_elements[], fmi3DependencyKind kinds[],
                                       size_t count) {
    ENTER(ANY | INTERMEDIATE);
    NEEDS_ANSWERS((dependent_elements && independents && independent_elements && kinds) ||
                  count == 0);
    const dependency *d = dependencies_of(c, dependent, count);
    for (size_t i = 0; d && i < count; ++i) {
        dependent_elements[i] = d[i].element;
        independents[i] = d[i].known;
        independent_elements[i] = d[i].known_element;
        kinds[i] = (fmi3DependencyKind)d[i].kind;
    }
    return d ? fmi3OK : fmi3Error;
}

/* ---- states ---- */

fmi3Status fmi3GetFMUState(fmi3Instance self, fmi3FMUState *state) {
    ENTER(ANY);
    return (fmi3Status)keep_state(c, state);
}

fmi3Status fmi3SetFMUState(fmi3Instance self, fmi3FMUState state) {
    ENTER(ANY);
    return (fmi3Status)restore_state(c, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance self, fmi3FMUState *state) {
    ENTER(ANY | INTERMEDIATE);
    return (fmi3Status)free_state(c, state);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance self, fmi3FMUState state, size_t *size) {
    ENTER(ANY | INTERMEDIATE);
    return (fmi3Status)state_size(c, state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance self, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size) {
    ENTER(ANY | INTERMEDIATE);
    return (fmi3Status)write_state(c, state, bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance self, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state) {
    ENTER(ANY | INTERMEDIATE);
    return (fmi3Status)read_state(c, bytes, size, state);
}

/* ---- events ---- */

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance self) {
    ENTER(EVENT);
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance self, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *event,
                                    fmi3Float64 *event_time) {
    ENTER(EVENT);
    NEEDS_ANSWERS(again && terminate && nominals && values && event && event_time);
    *again = *terminate = *nominals = *values = *event = false;
    *event_time = 0.0;
    return fmi3OK;
}

/* ---- model exchange ---- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance self) {
    ENTER(EVENT);
    c->now.phase = CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance self, fmi3Boolean no_return,
                                       fmi3Boolean *event, fmi3Boolean *terminate) {
    ENTER(CONTINUOUS);
    (void)no_return;
    NEEDS_ANSWERS(event && terminate);
    *event = *terminate = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance self, fmi3Float64 t) {
    ENTER(EVENT | CONTINUOUS);
    return (fmi3Status)set_time(c, t);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance self, const fmi3Float64 x[], size_t count) {
    ENTER(CONTINUOUS);
    return (fmi3Status)set_states(c, x, count);
}

enum { EVALUABLE = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED };

fmi3Status fmi3GetContinuousStates(fmi3Instance self, fmi3Float64 x[], size_t count) {
    ENTER(EVALUABLE);
    NEEDS_EXCHANGE;
    return (fmi3Status)get_states(c, x, count);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance self, fmi3Float64 rates[],
                                             size_t count) {
    ENTER(EVALUABLE);
    NEEDS_EXCHANGE;
    return (fmi3Status)get_rates(c, rates, count);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance self, fmi3Float64 nominals[],
                                             size_t count) {
    ENTER(EVALUABLE);
    NEEDS_EXCHANGE;
    return (fmi3Status)get_nominals(c, nominals, count);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance self, fmi3Float64 indicators[], size_t count) {
    ENTER(EVALUABLE);
    NEEDS_EXCHANGE;
    (void)indicators;
    NEEDS(count == 0, "there are no event indicators");
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance self, size_t *count) {
    ENTER(ANY);
    NEEDS_EXCHANGE;
    NEEDS_ANSWERS(count);
    *count = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance self, size_t *count) {
    ENTER(ANY);
    NEEDS_EXCHANGE;
    NEEDS_ANSWERS(count);
    *count = c->n.states;
    return fmi3OK;
}

/* ---- co-simulation ---- */

fmi3Status fmi3GetOutputDerivatives(fmi3Instance self, const fmi3ValueReference references[],
                                    size_t count, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t room) {
    ENTER(STEP | INTERMEDIATE | TERMINATED);
    return (fmi3Status)output_derivatives(c, references, count, orders, values, room);
}

fmi3Status fmi3DoStep(fmi3Instance self, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_return,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    ENTER(STEP);
    (void)no_return;
    NEEDS_ANSWERS(event && terminate && early && reached);
    *event = *terminate = *early = false;
    const status start = c->now;
    memcpy(c->before, c->values, c->count * sizeof *c->values);
    const answer how = do_step(c, t, h);
    if (how == FMI_DISCARD) { /* as if it had not been called */
        c->now = start;
        c->now.ahead = 0; /* the integrator is elsewhere */
        memcpy(c->values, c->before, c->count * sizeof *c->values);
        c->stale = 1;
    }
    *reached = c->now.t;
    *early = how == FMI_OK && c->now.t < t + h;
    return (fmi3Status)how;
}
