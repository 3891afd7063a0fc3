/* Instances: made from the files in resources, brought up to date, freed. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"

static const char *const CATEGORY[] = {"logAll", "logStatusWarning", "logStatusDiscard",
                                       "logStatusError", "logStatusFatal"};
enum { CATEGORIES = 5, FAILURES = 1 << fmi2Discard | 1 << fmi2Error | 1 << fmi2Fatal, ALL = 31 };
static const uint64_t MOST_STEPS = 1000000; /* of one call of doStep */

fmi2Status tell(instance *c, fmi2Status how, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->last_error, sizeof c->last_error, format, arguments);
    va_end(arguments);
    if (!c->logger || !(c->told & 1u << how)) return how;
    char text[2 * sizeof c->last_error], *to = text; /* the logger takes it as a format */
    for (const char *from = c->last_error; *from; ++from) {
        if (*from == '%') *to++ = '%';
        *to++ = *from;
    }
    *to = 0;
    c->logger(c->environment, c->name, how, CATEGORY[how], text);
    return how;
}

int allowed(instance *c, unsigned phases, const char *function) {
    static const char *const NAME[] = {"before initialization", "in initialization mode",
                                       "in event mode", "in continuous-time mode",
                                       "between steps", "after a step that failed",
                                       "after fmi2Terminate"};
    if (!c) return 0;
    if (c->now.phase & phases) return 1;
    int i = 0;
    while (c->now.phase >> i > 1) ++i;
    tell(c, fmi2Error, "%s cannot be called %s", function, NAME[i]);
    return 0;
}

uint32_t first_input(const instance *c) { return c->n.parameters + c->n.calculated; }
uint32_t first_state(const instance *c) { return first_input(c) + c->n.inputs; }
uint32_t first_output(const instance *c) { return first_state(c) + c->n.states; }
uint32_t reals(const instance *c) { return first_output(c) + c->n.outputs; }

/* In the binary form calculated parameters come last. */
const char *name_of(const instance *c, uint32_t reference) {
    uint32_t place = reference;
    if (reference >= first_input(c))
        place -= c->n.calculated;
    else if (reference >= c->n.parameters)
        place += c->n.inputs + c->n.states + c->n.outputs;
    return m4e_program_name(c->program, place);
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
    m4e_calculated(c->model, c->calculated);
    c->stale = 0;
}

static m4e_program *read_program(instance *c, const char *file) {
    size_t size = 0;
    char *path = files_path(c->resources, file), problem[128] = "cannot be read";
    uint8_t *bytes = path ? files_read(path, &size) : NULL;
    m4e_program *p = bytes ? m4e_program_read(bytes, size, problem, sizeof problem) : NULL;
    if (!p) tell(c, fmi2Error, "%s %s", path ? path : file, problem);
    free(bytes);
    free(path);
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
        tell(c, fmi2Error, "tangent.m4e is not of this FMU");
        return 0;
    }
    if (!c->direction) c->direction = calloc(inputs, sizeof *c->direction);
    if (!c->changes) c->changes = calloc(outputs + (size_t)1, sizeof *c->changes);
    if (c->direction && c->changes)
        c->tangent = new_model(c->tangent_program, c->n.states, outputs - c->n.states);
    if (!c->tangent) tell(c, fmi2Error, "no memory for derivatives");
    return c->tangent != NULL;
}

void differentiate(instance *c) {
    if (c->stale_tangent) m4e_set_parameters(c->tangent, c->p);
    c->stale_tangent = 0;
    if (c->n.inputs) memcpy(c->direction, c->u, c->n.inputs * sizeof *c->u);
    m4e_set_inputs(c->tangent, c->direction);
    m4e_outputs(c->tangent, c->now.t, c->x, c->changes);
}

int have_integrator(instance *c) {
    const double tolerance = c->now.tolerance;
    if (c->integrator && c->built_tolerance == tolerance) return 1;
    const m4e_options options = {.method = c->method, .rtol = tolerance, .atol = tolerance,
                                 .max_step = INFINITY, .max_steps = MOST_STEPS};
    m4e_integrator_free(c->integrator);
    c->integrator = m4e_integrator_new(c->model, &options, NULL);
    c->built_tolerance = tolerance;
    if (!c->integrator) tell(c, fmi2Error, "no memory for the integrator");
    return c->integrator != NULL;
}

static int make_room(instance *c) {
    const size_t p = c->n.parameters, u = c->n.inputs, x = c->n.states;
    c->count = p + 3 * u + x;
    c->values = calloc(c->count + 1, sizeof *c->values);
    c->y = calloc((size_t)c->n.outputs + c->n.calculated + 1, sizeof *c->y);
    if (!c->values || !c->y) return 0;
    c->p = c->values;
    c->u = c->p + p;
    c->x = c->u + u;
    c->first = c->x + x;
    c->second = c->first + u;
    c->calculated = c->y + c->n.outputs;
    c->model = new_model(c->program, 0, c->n.outputs);
    return c->model != NULL;
}

/* fmu.txt: the GUID, the integration method (its number in m4e.h) and the default tolerance, without
   a decimal point, which strtod would look for as the locale writes it. */
static int read_identity(instance *c, const char *guid) {
    char *path = files_path(c->resources, "fmu.txt");
    size_t size = 0, length = strlen(guid);
    char *text = path ? (char *)files_read(path, &size) : NULL;
    const int there = text != NULL;
    const int same = there && size > length && memcmp(text, guid, length) == 0 && text[length] == ' ';
    if (same) {
        char *end = NULL;
        c->method = (int32_t)strtol(text + length, &end, 10);
        c->default_tolerance = strtod(end, NULL);
    }
    free(text);
    if (!there) tell(c, fmi2Error, "%s cannot be read", path ? path : "fmu.txt");
    if (there && !same) tell(c, fmi2Error, "the GUID %.80s is not that of this FMU", guid);
    free(path);
    c->now.identity = UINT64_C(0xcbf29ce484222325); /* FNV-1a */
    for (const char *g = guid; *g; ++g)
        c->now.identity = (c->now.identity ^ (uint8_t)*g) * UINT64_C(0x100000001b3);
    return same;
}

static char *copied(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

static void release(instance *c) {
    if (!c) return;
    m4e_integrator_free(c->integrator);
    m4e_model_free(c->tangent);
    m4e_model_free(c->model);
    m4e_program_free(c->tangent_program);
    m4e_program_free(c->program);
    void *parts[] = {c->values, c->y, c->direction, c->changes, c->name, c->resources};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) free(parts[i]);
    free(c);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)visible;
    instance *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    if (functions) {
        c->logger = functions->logger;
        c->environment = functions->componentEnvironment;
    }
    c->told = logging ? ALL : FAILURES;
    c->name = copied(name ? name : "");
    c->resources = copied(resources ? resources : "");
    c->now.type = (uint32_t)type;
    if (!c->name || !c->resources) goto failed;
    if (!name || !*name || !guid || !resources || !functions ||
        (type != fmi2ModelExchange && type != fmi2CoSimulation)) {
        tell(c, fmi2Error, "fmi2Instantiate needs a name, a kind, a GUID, resources and callbacks");
        goto failed;
    }
    if (!read_identity(c, guid)) goto failed;
    c->program = read_program(c, "model.m4e");
    if (!c->program) goto failed;
    m4e_program_counts(c->program, &c->n);
    if (make_room(c)) {
        to_start(c);
        return c;
    }
    tell(c, fmi2Error, "no memory for an instance");
failed:
    release(c);
    return NULL;
}

void fmi2FreeInstance(fmi2Component component) { release(component); }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                               const fmi2String categories[]) {
    ENTER(ANY);
    CHECK(count == 0 || categories, "fmi2SetDebugLogging: no categories are given");
    unsigned told = count == 0 ? ALL : 0;
    for (size_t i = 0; i < count; ++i) {
        int known = 0;
        while (known < CATEGORIES && categories[i] && strcmp(categories[i], CATEGORY[known]) != 0)
            ++known;
        CHECK(known < CATEGORIES && categories[i], "there is no log category %.80s",
              categories[i] ? categories[i] : "");
        told |= known == 0 ? ALL : 1u << known;
    }
    c->told = on ? told : 0;
    return fmi2OK;
}
