/* Instances: made from the files in resources, brought up to date, freed. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const CATEGORY[] = {"logAll", "logStatusWarning", "logStatusDiscard",
                                       "logStatusError", "logStatusFatal"};
enum { CATEGORIES = 5 };
static const uint64_t MOST_STEPS = 1000000; /* of one call of doStep */

answer tell(instance *c, answer how, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->last_error, sizeof c->last_error, format, arguments);
    va_end(arguments);
    if (c->logger && (c->told & 1u << how)) c->log(c, how, CATEGORY[how], c->last_error);
    return how;
}

int allowed(instance *c, unsigned phases, const char *function) {
    static const char *const NAME[] = {"before initialization", "in initialization mode",
                                       "in event mode", "in continuous-time mode",
                                       "between steps", "after a step that failed",
                                       "after termination", "within a step"};
    if (!c) return 0;
    c->function = function;
    if ((phases & EXCHANGE) && (c->now.phase & phases) && c->now.type != MODEL_EXCHANGE) {
        tell(c, FMI_ERROR, "%s: this belongs to model exchange", function);
        return 0;
    }
    if (c->now.phase & phases) return 1;
    int i = 0;
    while (c->now.phase >> i > 1) ++i;
    tell(c, FMI_ERROR, "%s cannot be called %s", function, NAME[i]);
    return 0;
}

answer set_logging(instance *c, int on, size_t count, const char *const categories[]) {
    CHECK(count == 0 || categories, "%s: no categories are given", c->function);
    unsigned told = count == 0 ? TOLD_ALL : 0;
    for (size_t i = 0; i < count; ++i) {
        int known = 0;
        while (known < CATEGORIES && categories[i] && strcmp(categories[i], CATEGORY[known]) != 0)
            ++known;
        CHECK(known < CATEGORIES && categories[i], "there is no log category %.80s",
              categories[i] ? categories[i] : "");
        told |= known == 0 ? TOLD_ALL : 1u << known;
    }
    c->told = on ? told : 0;
    return FMI_OK;
}

uint32_t first_input(const instance *c) { return c->n.parameters; }
uint32_t first_state(const instance *c) { return first_input(c) + c->n.inputs; }
uint32_t first_output(const instance *c) { return first_state(c) + c->n.states; }
uint32_t first_calculated(const instance *c) { return first_output(c) + c->n.outputs; }
uint32_t scalars(const instance *c) { return first_calculated(c) + c->n.calculated; }

const char *name_of(const instance *c, uint32_t scalar) {
    return scalar == scalars(c) ? "time" : m4e_program_name(c->program, scalar);
}

const m4e_limits *limits_of(const instance *c, uint32_t scalar) {
    return m4e_program_limits(c->program) + scalar;
}

answer set_experiment(instance *c, int tolerant, double tolerance, double start, int stops,
                         double stop) {
    CHECK(isfinite(start), "the start time must be finite, got %g", start);
    CHECK(!stops || stop >= start, "the stop time %g s is before the start time %g s", stop, start);
    CHECK(!tolerant || (tolerance > 0.0 && isfinite(tolerance)),
          "the tolerance must be positive, got %g", tolerance);
    c->now.t = start;
    c->now.stops = stops != 0;
    c->now.stop = stops ? stop : INFINITY;
    if (tolerant) c->now.tolerance = tolerance;
    c->stale = 1;
    return FMI_OK;
}

void to_start(instance *c) {
    c->now = (status){.identity = c->now.identity, .type = c->now.type, .phase = INSTANTIATED,
                      .stop = INFINITY, .tolerance = c->default_tolerance};
    const size_t given = (size_t)c->n.parameters + c->n.inputs + c->n.states;
    memset(c->values, 0, c->count * sizeof *c->values);
    if (given) memcpy(c->values, m4e_program_starts(c->program), given * sizeof *c->values);
    c->stale = c->stale_parameters = c->stale_tangent = 1;
}

void prepare(instance *c) {
    if (c->stale_parameters) m4e_set_parameters(c->model, c->p);
    c->stale_parameters = 0;
    m4e_set_inputs(c->model, c->u);
}

void refresh(instance *c) {
    if (!c->stale) return;
    prepare(c);
    m4e_outputs(c->model, c->now.t, c->x, c->y);
    m4e_calculated(c->model, c->y + c->n.outputs);
    c->stale = 0;
}

uint8_t *read_resource(instance *c, const char *file, size_t *size) {
    char *path = files_path(c->resources, file);
    uint8_t *bytes = path ? files_read(path, size) : NULL;
    if (!bytes) tell(c, FMI_ERROR, "%s cannot be read", path ? path : file);
    free(path);
    return bytes;
}

static m4e_program *read_program(instance *c, const char *file) {
    size_t size = 0;
    char problem[128] = "";
    uint8_t *bytes = read_resource(c, file, &size);
    if (!bytes) return NULL;
    m4e_program *p = m4e_program_read(bytes, size, problem, sizeof problem);
    if (!p) tell(c, FMI_ERROR, "%s %s", file, problem);
    free(bytes);
    return p;
}

/* A model of the outputs from `first` on. */
static m4e_model *new_model(const m4e_program *program, uint32_t first, uint32_t outputs) {
    uint32_t *selected = malloc((outputs + (size_t)1) * sizeof *selected);
    for (uint32_t i = 0; selected && i < outputs; ++i) selected[i] = first + i;
    m4e_model *m = selected ? m4e_model_new(program, 1, outputs, selected, 0, NULL) : NULL;
    free(selected);
    return m;
}

int have_tangent(instance *c) {
    if (c->tangent) return 1;
    if (!c->tangent_program) c->tangent_program = read_program(c, "tangent.m4e");
    if (!c->tangent_program) return 0;
    m4e_counts n;
    m4e_program_counts(c->tangent_program, &n);
    const uint32_t inputs = 2 * c->n.inputs + 1 + c->n.states + c->n.parameters;
    const uint32_t outputs = c->n.states + c->n.outputs + c->n.calculated;
    if (n.states != c->n.states || n.parameters != c->n.parameters || n.inputs != inputs ||
        n.outputs != outputs) {
        tell(c, FMI_ERROR, "tangent.m4e is not of this FMU");
        return 0;
    }
    if (!c->direction) c->direction = calloc(inputs, sizeof *c->direction);
    if (!c->changes) c->changes = calloc(outputs + (size_t)1, sizeof *c->changes);
    if (c->direction && c->changes)
        c->tangent = new_model(c->tangent_program, c->n.states, outputs - c->n.states);
    if (!c->tangent) tell(c, FMI_ERROR, "no memory for derivatives");
    return c->tangent != NULL;
}

int have_integrator(instance *c) {
    const double tolerance = c->now.tolerance;
    if (c->integrator && c->built_tolerance == tolerance) return 1;
    const m4e_options options = {.method = c->method, .rtol = tolerance, .atol = tolerance,
                                 .max_step = c->method == M4E_RK4 ? c->step_size : INFINITY,
                                 .max_steps = MOST_STEPS};
    m4e_integrator_free(c->integrator);
    c->integrator = m4e_integrator_new(c->model, &options, NULL);
    c->built_tolerance = tolerance;
    if (!c->integrator) tell(c, FMI_ERROR, "no memory for the integrator");
    return c->integrator != NULL;
}

static int make_room(instance *c) {
    const size_t p = c->n.parameters, u = c->n.inputs, x = c->n.states;
    c->count = p + 3 * u + x;
    c->values = calloc(c->count + 1, sizeof *c->values);
    c->before = calloc(c->count + 1, sizeof *c->before);
    c->rates = calloc(x + 1, sizeof *c->rates);
    c->y = calloc((size_t)c->n.outputs + c->n.calculated + 1, sizeof *c->y);
    if (!c->values || !c->before || !c->rates || !c->y) return 0;
    c->p = c->values;
    c->u = c->p + p;
    c->x = c->u + u;
    c->first = c->x + x;
    c->second = c->first + u;
    c->model = new_model(c->program, 0, c->n.outputs);
    return c->model != NULL;
}

/* fmu.txt: the GUID, the integration method (its number in m4e.h), the default tolerance and the
   longest step of rk4 in seconds, both without a decimal point, which strtod would look for as the
   locale writes it. */
static int read_identity(instance *c, const char *guid) {
    size_t size = 0, length = strlen(guid);
    char *text = (char *)read_resource(c, "fmu.txt", &size), *end = NULL;
    if (!text) return 0;
    const int same = size > length && memcmp(text, guid, length) == 0 && text[length] == ' ' &&
                     !strchr(guid, ' ');
    if (same) {
        c->method = (int32_t)strtol(text + length, &end, 10);
        c->default_tolerance = strtod(end, &end);
        c->step_size = strtod(end, NULL);
    }
    free(text);
    if (!same) tell(c, FMI_ERROR, "the GUID %.80s is not that of this FMU", guid);
    c->now.identity = UINT64_C(0xcbf29ce484222325); /* FNV-1a */
    for (const char *g = guid; *g; ++g)
        c->now.identity = (c->now.identity ^ (uint8_t)*g) * UINT64_C(0x100000001b3);
    return same;
}

static char *copied(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

void instance_free(instance *c) {
    if (!c) return;
    m4e_integrator_free(c->integrator);
    m4e_model_free(c->tangent);
    m4e_model_free(c->model);
    m4e_program_free(c->tangent_program);
    m4e_program_free(c->program);
    void *parts[] = {c->values,       c->before,        c->rates,        c->y,
                     c->direction,    c->changes,       c->listed[0], c->listed[1],
                     c->name,         c->resources};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) free(parts[i]);
    free(c);
}

/* Reads what the instance is made from. */
static int build(instance *c, const request *wanted) {
    if (!wanted->name || !*wanted->name || !wanted->token || !wanted->resources ||
        wanted->type > CO_SIMULATION) {
        tell(c, FMI_ERROR, "an instance needs a name, a kind, a GUID and the path of resources");
        return 0;
    }
    if (!read_identity(c, wanted->token)) return 0;
    c->program = read_program(c, "model.m4e");
    if (!c->program) return 0;
    m4e_program_counts(c->program, &c->n);
    if (make_room(c)) return 1;
    tell(c, FMI_ERROR, "no memory for an instance");
    return 0;
}

instance *instance_new(const request *wanted) {
    instance *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->log = wanted->log;
    c->logger = wanted->logger;
    c->environment = wanted->environment;
    c->told = TOLD_FAILURES;
    c->name = copied(wanted->name ? wanted->name : "");
    c->resources = copied(wanted->resources ? wanted->resources : "");
    c->now.type = wanted->type;
    c->time_first = wanted->time_first;
    if (c->name && c->resources && build(c, wanted)) {
        to_start(c);
        return c;
    }
    instance_free(c);
    return NULL;
}
