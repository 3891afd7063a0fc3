/* The functions of FMI 2.0 and 3.0: when each may be called, and what it does.

   A call that is refused answers an error with a text and changes nothing, though FMI 3.0 lets an
   importer count on less. Where the equations have no finite value the answer is Discard: a smaller
   step, or other inputs, may help; in FMI 3.0 the FMU is as it was before the call. There are
   neither clocks nor structural parameters nor events. Sources: FMI Specification 2.0.4, sections
   2.1, 3.2 and 4.2; 3.0.2, sections 2.2, 2.3, 3.2, 4.2 and 5.2. */
#include <stdbool.h>
#include <string.h>

#include "instance.h"

#ifdef _WIN32
#define FMI(type) __declspec(dllexport) type
#else
#define FMI(type) __attribute__((visibility("default"))) type
#endif
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* the standards have more than is used */
#endif

typedef const char *text;
typedef const uint8_t *binary;
typedef const uint32_t references[];

#define ENTER(phases)                                                                              \
    instance *c = self;                                                                            \
    if (!allowed(c, phases, __func__)) return FMI_ERROR
#define NEEDS_ANSWERS(condition)                                                                   \
    CHECK(condition, "%s: there is nowhere to put the answer", c->function)
/* A function: phases, parameters, what it does with the instance `c`. */
#define FUNCTION(name, phases, parameters, ...)                                                    \
    FMI(answer) name parameters {                                                                  \
        ENTER(phases);                                                                             \
        __VA_ARGS__                                                                                \
    }
/* The same in both versions. */
#define BOTH(name2, phases2, name3, phases3, parameters, ...)                                      \
    FUNCTION(fmi2##name2, phases2, parameters, __VA_ARGS__)                                        \
    FUNCTION(fmi3##name3, phases3, parameters, __VA_ARGS__)

/* Values of a type that no variable of these FMUs has. */
#define NONE(name, ...)                                                                            \
    FUNCTION(name, ALWAYS, (void *self, references r, size_t count, __VA_ARGS__),                  \
             CHECK(count == 0, "%s: there is no such variable", c->function);                      \
             return FMI_OK;)

enum {
    WITHIN = READABLE | INTERMEDIATE, ALWAYS = ANY | INTERMEDIATE,
    EVALUABLE = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED,
    STEPPED = STEP | FAILED | TERMINATED
};

static answer enter(instance *c, uint32_t phase) {
    c->now.phase = phase;
    return FMI_OK;
}

/* ---- both versions ---- */

BOTH(ExitInitializationMode, INITIALIZATION, ExitInitializationMode, INITIALIZATION, (void *self),
     return enter(c, c->now.type == CO_SIMULATION ? STEP : EVENT);)
BOTH(EnterEventMode, EVENT | CONTINUOUS, EnterEventMode, CONTINUOUS, (void *self),
     return enter(c, EVENT);)
BOTH(EnterContinuousTimeMode, EVENT, EnterContinuousTimeMode, EVENT, (void *self),
     return enter(c, CONTINUOUS);)
BOTH(Terminate, EVENT | CONTINUOUS | STEP | FAILED, Terminate, EVENT | CONTINUOUS | STEP,
     (void *self), return enter(c, TERMINATED);)
BOTH(Reset, ANY, Reset, ANY, (void *self),
     to_start(c);
     c->last_error[0] = 0;
     return FMI_OK;)

BOTH(GetFMUstate, ANY, GetFMUState, ANY, (void *self, void **state), return keep_state(c, state);)
BOTH(SetFMUstate, ANY, SetFMUState, ANY, (void *self, void *state), return restore_state(c, state);)
BOTH(FreeFMUstate, ANY, FreeFMUState, ALWAYS, (void *self, void **state),
     return free_state(c, state);)
BOTH(SerializedFMUstateSize, ANY, SerializedFMUStateSize, ALWAYS,
     (void *self, void *state, size_t *size), return state_size(c, state, size);)
BOTH(SerializeFMUstate, ANY, SerializeFMUState, ALWAYS,
     (void *self, void *state, uint8_t bytes[], size_t size),
     return write_state(c, state, bytes, size);)
BOTH(DeSerializeFMUstate, ANY, DeserializeFMUState, ALWAYS,
     (void *self, const uint8_t bytes[], size_t size, void **state),
     return read_state(c, bytes, size, state);)

BOTH(SetTime, EVENT | CONTINUOUS, SetTime, EVENT | CONTINUOUS, (void *self, double t),
     return set_time(c, t);)
BOTH(SetContinuousStates, CONTINUOUS, SetContinuousStates, CONTINUOUS,
     (void *self, const double x[], size_t count), return set_states(c, x, count);)
BOTH(GetContinuousStates, EVALUABLE, GetContinuousStates, EVALUABLE | EXCHANGE,
     (void *self, double x[], size_t count), return get_states(c, x, count);)
BOTH(GetDerivatives, EVALUABLE, GetContinuousStateDerivatives, EVALUABLE | EXCHANGE,
     (void *self, double rates[], size_t count), return get_rates(c, rates, count);)
BOTH(GetNominalsOfContinuousStates, INSTANTIATED | EVALUABLE, GetNominalsOfContinuousStates,
     EVALUABLE | EXCHANGE, (void *self, double nominals[], size_t count),
     return get_nominals(c, nominals, count);)
BOTH(GetEventIndicators, EVALUABLE, GetEventIndicators, EVALUABLE | EXCHANGE,
     (void *self, double indicators[], size_t count),
     CHECK(count == 0, "%s: there are no event indicators", c->function);
     return FMI_OK;)

/* ---- FMI 2.0 ---- */

typedef void logger_2(void *environment, text name, answer, text category, text message, ...);
typedef struct {
    logger_2 *logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *environment, answer);
    void *environment;
} callbacks;
typedef struct {
    int needed, terminate, nominals_changed, values_changed, next_event_defined;
    double next_event;
} event_info;
enum { LAST_SUCCESSFUL_TIME = 2, IS_TERMINATED = 3 }; /* of fmi2StatusKind */

static void log_2(const instance *c, answer how, text category, text message) {
    char escaped[2 * sizeof c->last_error], *to = escaped; /* the logger takes it as a format */
    for (const char *from = message; *from; ++from) {
        if (*from == '%') *to++ = '%';
        *to++ = *from;
    }
    *to = 0;
    ((logger_2 *)c->logger)(c->environment, c->name, how, category, escaped);
}

FMI(text) fmi2GetTypesPlatform(void) { return "default"; }
FMI(text) fmi2GetVersion(void) { return "2.0"; }

FMI(void *)
fmi2Instantiate(text name, int type, text guid, text resources, const callbacks *functions,
                int visible, int logs) {
    if (!functions) return NULL;
    instance *c = instance_new(&(request){.name = name,
                                          .token = guid,
                                          .resources = resources,
                                          .type = (uint32_t)type,
                                          .environment = functions->environment,
                                          .log = log_2,
                                          .logger = (callback *)functions->logger});
    if (c && logs) c->told = TOLD_ALL;
    return c;
}

FMI(void) fmi2FreeInstance(void *self) { instance_free(self); }

FUNCTION(fmi2SetDebugLogging, ANY, (void *self, int on, size_t count, const text categories[]),
         return set_logging(c, on, count, categories);)
FUNCTION(fmi2SetupExperiment, INSTANTIATED,
         (void *self, int tolerant, double tolerance, double start, int stops, double stop),
         return set_experiment(c, tolerant, tolerance, start, stops, stop);)
FUNCTION(fmi2EnterInitializationMode, INSTANTIATED, (void *self), return enter(c, INITIALIZATION);)

FUNCTION(fmi2GetReal, READABLE, (void *self, references r, size_t count, double values[]),
         return get_values(c, r, count, values, count);)
FUNCTION(fmi2SetReal, SETTABLE, (void *self, references r, size_t count, const double values[]),
         return set_values(c, r, count, values, count);)
FUNCTION(fmi2GetString, READABLE, (void *self, references r, size_t count, text values[]),
         return get_text(c, r, count, values, count);)
NONE(fmi2GetInteger, int values[])
NONE(fmi2GetBoolean, int values[])
NONE(fmi2SetInteger, const int values[])
NONE(fmi2SetBoolean, const int values[])
NONE(fmi2SetString, const text values[])
FUNCTION(fmi2GetDirectionalDerivative, READABLE,
         (void *self, references unknown, size_t unknowns, references known, size_t knowns,
          const double seed[], double result[]),
         return directional_derivative(c, unknown, unknowns, known, knowns, seed, knowns, result,
                                       unknowns);)

FUNCTION(fmi2NewDiscreteStates, EVENT, (void *self, event_info *info),
         NEEDS_ANSWERS(info);
         *info = (event_info){0};
         return FMI_OK;)
FUNCTION(fmi2CompletedIntegratorStep, CONTINUOUS,
         (void *self, int no_return, int *event, int *terminate),
         NEEDS_ANSWERS(event && terminate);
         *event = *terminate = 0;
         return FMI_OK;)

FUNCTION(fmi2SetRealInputDerivatives, INSTANTIATED | INITIALIZATION | STEP,
         (void *self, references r, size_t count, const int order[], const double values[]),
         return set_input_derivatives(c, r, count, order, values);)
FUNCTION(fmi2GetRealOutputDerivatives, STEPPED,
         (void *self, references r, size_t count, const int order[], double values[]),
         return output_derivatives(c, r, count, order, values, count);)
FUNCTION(fmi2DoStep, STEP, (void *self, double t, double h, int no_return),
         return do_step(c, t, h);)
FUNCTION(fmi2CancelStep, 0, (void *self), return FMI_OK;) /* a step is never still going on */
FUNCTION(fmi2GetRealStatus, STEPPED, (void *self, int kind, double *value),
         NEEDS_ANSWERS(value);
         if (kind != LAST_SUCCESSFUL_TIME) return FMI_DISCARD;
         *value = c->now.t;
         return FMI_OK;)
FUNCTION(fmi2GetBooleanStatus, STEPPED, (void *self, int kind, int *value),
         NEEDS_ANSWERS(value);
         if (kind != IS_TERMINATED) return FMI_DISCARD;
         *value = 0;
         return FMI_OK;) /* a step that failed is no wish to end the simulation */
#define NO_STATUS(name, value) /* of a step that is still going on */                              \
    FUNCTION(fmi2##name, STEPPED, (void *self, int kind, value),                                   \
             return tell(c, FMI_DISCARD, "%s: no step is going on", c->function);)
NO_STATUS(GetStatus, int *value)
NO_STATUS(GetIntegerStatus, int *value)
NO_STATUS(GetStringStatus, text *value)

/* ---- FMI 3.0 ---- */

typedef void logger_3(void *environment, answer, text category, text message);
typedef void update(void *environment, double time, bool set, bool get, bool finished,
                    bool may_return, bool *early, double *early_time);

static void log_3(const instance *c, answer how, text category, text message) {
    ((logger_3 *)c->logger)(c->environment, how, category, message);
}

static instance *made(uint32_t type, text name, text token, text resources, void *environment,
                      logger_3 *logger) {
    return instance_new(&(request){.name = name,
                                   .token = token,
                                   .resources = resources,
                                   .time_first = 1,
                                   .type = type,
                                   .environment = environment,
                                   .log = log_3,
                                   .logger = (callback *)logger});
}

/* Shows the importer a step of the integrator; answers where to stop. */
static double observe(instance *c, double end) {
    bool early = false;
    double wanted = end;
    const bool may_return = c->may_return && c->now.t < end;
    ((update *)c->observer)(c->environment, c->now.t, true, true, true, may_return, &early,
                            &wanted);
    if (!may_return || !early || !(wanted < end)) return end;
    return wanted > c->now.t ? wanted : c->now.t;
}

FMI(text) fmi3GetVersion(void) { return "3.0"; }

FMI(void *)
fmi3InstantiateModelExchange(text name, text token, text resources, bool visible, bool logs,
                             void *environment, logger_3 *logger) {
    instance *c = made(MODEL_EXCHANGE, name, token, resources, environment, logger);
    if (c) c->told = logs ? TOLD_ALL : TOLD_NOTHING;
    return c;
}

FMI(void *)
fmi3InstantiateCoSimulation(text name, text token, text resources, bool visible, bool logs,
                            bool events, bool early, references intermediate, size_t count,
                            void *environment, logger_3 *logger, update *observer) {
    instance *c = made(CO_SIMULATION, name, token, resources, environment, logger);
    if (!c) return NULL;
    c->told = TOLD_ALL;
    bool sound = !events && (count == 0 || intermediate);
    for (size_t i = 0; sound && i < count; ++i) sound = intermediate[i] < reference_count(c);
    if (!sound) {
        tell(c, FMI_ERROR, "%s: %s", __func__,
             events ? "there is no event mode" : "an intermediate variable is none");
        instance_free(c);
        return NULL;
    }
    c->may_return = early;
    c->observer = (callback *)observer;
    c->observe = observer ? observe : NULL;
    c->told = logs ? TOLD_ALL : TOLD_NOTHING;
    return c;
}

FMI(void *)
fmi3InstantiateScheduledExecution(text name, text token, text resources, bool visible,
                                  bool logs, void *environment, logger_3 *logger,
                                  callback *clock_update, callback *lock, callback *unlock) {
    if (logger)
        logger(environment, FMI_ERROR, "logStatusError",
               "this FMU has no scheduled execution, only co-simulation and model exchange");
    return NULL;
}

FMI(void) fmi3FreeInstance(void *self) {
    instance *c = self;
    if (c && c->now.phase == INTERMEDIATE)
        allowed(c, ANY, __func__); /* fmi3DoStep still needs it */
    else
        instance_free(c);
}

FUNCTION(fmi3SetDebugLogging, ALWAYS, (void *self, bool on, size_t count, const text categories[]),
         return set_logging(c, on, count, categories);)
FUNCTION(fmi3EnterInitializationMode, INSTANTIATED,
         (void *self, bool tolerant, double tolerance, double start, bool stops, double stop),
         const answer how = set_experiment(c, tolerant, tolerance, start, stops, stop);
         return how == FMI_OK ? enter(c, INITIALIZATION) : how;)

FUNCTION(fmi3GetFloat64, INSTANTIATED | WITHIN,
         (void *self, references r, size_t count, double values[], size_t room),
         return get_values(c, r, count, values, room);)
FUNCTION(fmi3SetFloat64, SETTABLE | INTERMEDIATE,
         (void *self, references r, size_t count, const double values[], size_t given),
         return set_values(c, r, count, values, given);)
FUNCTION(fmi3GetString, INSTANTIATED | WITHIN,
         (void *self, references r, size_t count, text values[], size_t room),
         return get_text(c, r, count, values, room);)
#define DERIVATIVE(name, function)                                                                 \
    FUNCTION(name, WITHIN,                                                                         \
             (void *self, references unknown, size_t unknowns, references known, size_t knowns,    \
              const double seed[], size_t seeds, double result[], size_t results),                 \
             return function(c, unknown, unknowns, known, knowns, seed, seeds, result, results);)
DERIVATIVE(fmi3GetDirectionalDerivative, directional_derivative)
DERIVATIVE(fmi3GetAdjointDerivative, adjoint_derivative)
FUNCTION(fmi3GetOutputDerivatives, STEP | INTERMEDIATE | TERMINATED,
         (void *self, references r, size_t count, const int32_t orders[], double values[],
          size_t room),
         return output_derivatives(c, r, count, orders, values, room);)
#define NO_DEPENDENCIES                                                                            \
    return tell(c, FMI_ERROR, "%s: they are in the model description", c->function);
FUNCTION(fmi3GetNumberOfVariableDependencies, ALWAYS,
         (void *self, uint32_t reference, size_t *count), (void)reference, (void)count;
         NO_DEPENDENCIES)
FUNCTION(fmi3GetVariableDependencies, ALWAYS,
         (void *self, uint32_t dependent, size_t elements[], uint32_t known[],
          size_t known_elements[], int kinds[], size_t count),
         (void)dependent, (void)elements, (void)known, (void)known_elements, (void)kinds,
         (void)count;
         NO_DEPENDENCIES)

FUNCTION(fmi3EvaluateDiscreteStates, EVENT, (void *self), return FMI_OK;)
FUNCTION(fmi3UpdateDiscreteStates, EVENT,
         (void *self, bool *again, bool *terminate, bool *nominals, bool *values, bool *event,
          double *event_time),
         NEEDS_ANSWERS(again && terminate && nominals && values && event && event_time);
         *again = *terminate = *nominals = *values = *event = false;
         *event_time = 0.0;
         return FMI_OK;)
FUNCTION(fmi3CompletedIntegratorStep, CONTINUOUS,
         (void *self, bool no_return, bool *event, bool *terminate),
         NEEDS_ANSWERS(event && terminate);
         *event = *terminate = false;
         return FMI_OK;)
FUNCTION(fmi3GetNumberOfEventIndicators, ANY | EXCHANGE, (void *self, size_t *count),
         NEEDS_ANSWERS(count);
         *count = 0;
         return FMI_OK;)
FUNCTION(fmi3GetNumberOfContinuousStates, ANY | EXCHANGE, (void *self, size_t *count),
         NEEDS_ANSWERS(count);
         *count = c->n.states;
         return FMI_OK;)

FMI(answer)
fmi3DoStep(void *self, double t, double h, bool no_return, bool *event, bool *terminate,
           bool *early, double *reached) {
    ENTER(STEP);
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
    return how;
}

/* What these FMUs have not: modes that are never entered, variables of other types, clocks. */
FUNCTION(fmi3EnterConfigurationMode, INSTANTIATED | EVENT | STEP, (void *self),
         return tell(c, FMI_ERROR, "%s: there are no structural parameters", c->function);)
FUNCTION(fmi3ExitConfigurationMode, 0, (void *self), return FMI_OK;)
FUNCTION(fmi3EnterStepMode, 0, (void *self), return FMI_OK;)
FUNCTION(fmi3ActivateModelPartition, 0, (void *self, uint32_t clock, double t), return FMI_OK;)
#define NO_NUMBER(Type, type)                                                                      \
    NONE(fmi3Get##Type, type values[], size_t room)                                                \
    NONE(fmi3Set##Type, const type values[], size_t given)
NO_NUMBER(Float32, float)
NO_NUMBER(Int8, int8_t)
NO_NUMBER(UInt8, uint8_t)
NO_NUMBER(Int16, int16_t)
NO_NUMBER(UInt16, uint16_t)
NO_NUMBER(Int32, int32_t)
NO_NUMBER(UInt32, uint32_t)
NO_NUMBER(Int64, int64_t)
NO_NUMBER(UInt64, uint64_t)
NO_NUMBER(Boolean, bool)
NONE(fmi3SetString, const text values[], size_t given)
NONE(fmi3GetBinary, size_t sizes[], binary values[], size_t room)
NONE(fmi3SetBinary, const size_t sizes[], const binary values[], size_t given)
NONE(fmi3GetClock, bool values[])
NONE(fmi3SetClock, const bool values[])
NONE(fmi3GetIntervalDecimal, double intervals[], int qualifiers[])
NONE(fmi3GetIntervalFraction, uint64_t counters[], uint64_t resolutions[], int qualifiers[])
NONE(fmi3GetShiftDecimal, double shifts[])
NONE(fmi3GetShiftFraction, uint64_t counters[], uint64_t resolutions[])
NONE(fmi3SetIntervalDecimal, const double intervals[])
NONE(fmi3SetIntervalFraction, const uint64_t counters[], const uint64_t resolutions[])
NONE(fmi3SetShiftDecimal, const double shifts[])
NONE(fmi3SetShiftFraction, const uint64_t counters[], const uint64_t resolutions[])
