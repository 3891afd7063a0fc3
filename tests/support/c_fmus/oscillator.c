/* An FMI 2.0 FMU, co-simulation and model exchange, by the book: a mass on a hardening spring, pulled
 * by a force through a filter. Each macro DEFECT_... plants one fault into it.
 *
 *   x' = v,  v' = a = (z - k x - d v - c x^3) / m,  z' = (force - z) / tau
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { MASS, DAMPING, STIFFNESS, RATIO, FORCE, X, V, A, POWER, LOAD, STRETCH, Z, RATE, N };
enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, STEP = 16, FAILED = 32, TERMINATED = 64 };
enum { RUNNING = EVENT | CONTINUOUS | STEP, LATER = RUNNING | INITIALIZATION | FAILED | TERMINATED, ANY = LATER | INSTANTIATED };
static const double start[N] = {[MASS] = 2, [DAMPING] = 0.3, [STIFFNESS] = 5, [FORCE] = 0.5, [X] = 0.4, [Z] = 0.1};
static const double CUBIC = 0.8, TAU = 0.2, LARGEST_SUBSTEP = 0.001;

typedef struct {
    double r[N];
    double slope; /* of the force during the next step */
    double t, stop;
    int phase;
} Values;
typedef struct {
    Values now;
    fmi2Type type;
    fmi2CallbackFunctions callbacks;
    char *name;
} Model;

static fmi2Status tell(Model *m, fmi2Status status, const char *text) {
    m->callbacks.logger(m->callbacks.componentEnvironment, m->name, status, "logStatus", "%s", text);
    return status;
}
#define ENTER(phases)                                                                             \
    Model *m = c;                                                                                 \
    if (!(m->now.phase & (phases))) return tell(m, fmi2Error, __func__)
#define CHECK(condition, text)                                                                    \
    if (!(condition)) return tell(m, fmi2Error, text)

#ifdef DEFECT_SHARED
static double shared;
#define FILTERED(m) shared
#else
#define FILTERED(m) (m)->now.r[Z]
#endif

static double stiffness(const Model *m) {
    double k = m->now.r[STIFFNESS];
    return k;
}

static void rates(const Model *m, double force, const double s[3], double ds[3]) {
    const double *r = m->now.r;
    ds[0] = s[1];
    ds[1] = (s[2] - stiffness(m) * s[0] - r[DAMPING] * s[1] - CUBIC * s[0] * s[0] * s[0]) / r[MASS];
    ds[2] = (force - s[2]) / TAU;
}

static void update(Model *m) {
    double *r = m->now.r, s[3] = {r[X], r[V], FILTERED(m)}, ds[3];
    rates(m, r[FORCE], s, ds);
    r[RATIO] = r[STIFFNESS] / r[MASS];
    r[A] = ds[1];
    r[RATE] = ds[2];
    r[POWER] = r[FORCE] * r[V];
    r[LOAD] = 3 * r[FORCE] + stiffness(m) * r[X];
    r[STRETCH] = 2 * r[X];
}

static void to_start(Model *m) {
    double filtered = FILTERED(m);
    memset(&m->now, 0, sizeof m->now);
    memcpy(m->now.r, start, sizeof start);
    FILTERED(m) = start[Z];
#ifdef DEFECT_RESET
    if (filtered != 0) FILTERED(m) = filtered;
#endif
    m->now.phase = INSTANTIATED;
    m->now.stop = INFINITY;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
#if defined DEFECT_VERSION
const char *fmi2GetVersion(void) { return "1.0"; }
#elif defined DEFECT_NO_VERSION
const char *fmi2GetVersion(void) { return NULL; }
#else
const char *fmi2GetVersion(void) { return fmi2Version; }
#endif
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    if (strcmp(guid, "oscillator")) {
        functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatus", "this is not my GUID");
        return NULL;
    }
    Model *m = calloc(1, sizeof *m);
    memcpy(&m->callbacks, functions, sizeof *functions);
    m->type = type;
    m->name = strcpy(malloc(strlen(name) + 1), name);
    to_start(m);
    return m;
}
void fmi2FreeInstance(fmi2Component c) {
    free(((Model *)c)->name);
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real t0, fmi2Boolean stops, fmi2Real t1) {
    ENTER(INSTANTIATED);
    m->now.t = t0;
    m->now.stop = stops ? t1 : INFINITY;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ENTER(INSTANTIATED);
    m->now.phase = INITIALIZATION;
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ENTER(INITIALIZATION);
    update(m);
    m->now.phase = m->type == fmi2CoSimulation ? STEP : EVENT;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    ENTER(RUNNING | FAILED);
    m->now.phase = TERMINATED;
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component c) {
#ifdef DEFECT_RESET_CRASHES
    *(volatile int *)NULL = 0;
#endif
#ifdef DEFECT_RESET_HANGS
    for (volatile double still = 0;; still += 1e-9) continue;
#endif
    to_start(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    ENTER(LATER);
    update(m);
    m->now.r[Z] = FILTERED(m);
    for (size_t i = 0; i < n; i++) CHECK(vr[i] < N, "no such variable");
    fmi2Status status = fmi2OK;
    for (size_t i = 0; i < n; i++) {
        v[i] = m->now.r[vr[i] % N];
        if (!isfinite(v[i])) status = fmi2Discard;
    }
    return status == fmi2OK ? status : tell(m, status, "a value is not finite");
}

static int settable(const Model *m, fmi2ValueReference i) {
    int starting = m->now.phase & (INSTANTIATED | INITIALIZATION);
    if (i == FORCE || i == STIFFNESS) return 1;
    return starting && (i <= DAMPING || i == X || i == V || i == Z);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    ENTER(INSTANTIATED | INITIALIZATION | RUNNING);
    for (size_t i = 0; i < n; i++) {
        CHECK(vr[i] < N, "no such variable");
        CHECK(settable(m, vr[i]), "cannot be set now");
        CHECK(isfinite(v[i]), "not finite");
        if (vr[i] == Z) FILTERED(m) = v[i];
        else m->now.r[vr[i]] = v[i];
    }
    return fmi2OK;
}

/* Change of everything for a change `d` of what is known. */
static void change(const Model *m, double d[N]) {
    const double *r = m->now.r, k = stiffness(m);
    double dk = d[STIFFNESS] * (k / r[STIFFNESS]);
    d[A] = (d[Z] - dk * r[X] - k * d[X] - d[DAMPING] * r[V] - r[DAMPING] * d[V] - 3 * CUBIC * r[X] * r[X] * d[X] - d[MASS] * r[A]) / r[MASS];
    d[RATE] = (d[FORCE] - d[Z]) / TAU;
    d[POWER] = d[FORCE] * r[V] + r[FORCE] * d[V];
    d[LOAD] = 3 * d[FORCE] + dk * r[X] + k * d[X];
    d[STRETCH] = 2 * d[X];
    d[RATIO] = d[STIFFNESS] / r[MASS] - r[STIFFNESS] * d[MASS] / (r[MASS] * r[MASS]);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[], size_t nv, const fmi2Real dv[], fmi2Real dz[]) {
    ENTER(LATER);
    double d[N] = {0};
    update(m);
    m->now.r[Z] = FILTERED(m);
    for (size_t i = 0; i < nv; i++) d[v[i]] += dv[i];
    change(m, d);
#ifdef DEFECT_DIRECTIONAL_SIGN
    d[A] = -d[A];
#endif
#ifdef DEFECT_DIRECTIONAL_ENTRY
    d[A] -= 0.01 * m->now.r[DAMPING] * d[V] / m->now.r[MASS];
#endif
    for (size_t i = 0; i < nz; i++) dz[i] = d[z[i]];
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], fmi2Real v[]) {
    ENTER(STEP | FAILED | TERMINATED);
    double d[N] = {0};
    update(m);
    m->now.r[Z] = FILTERED(m);
    d[X] = m->now.r[V];
    d[V] = m->now.r[A];
    d[Z] = m->now.r[RATE];
    change(m, d);
    for (size_t i = 0; i < n; i++) v[i] = d[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real v[]) {
    ENTER(INSTANTIATED | INITIALIZATION | STEP);
    for (size_t i = 0; i < n; i++) {
        CHECK(vr[i] == FORCE && order[i] == 1, "only the force, only first order");
        m->now.slope = v[i];
    }
    return fmi2OK;
}

/* Runge and Kutta's method in short steps; 0 if the solution is lost. */
static int integrate(Model *m, double h) {
    double *r = m->now.r, s[3] = {r[X], r[V], FILTERED(m)};
    long n = (long)ceil(h / LARGEST_SUBSTEP);
    double d = h / n;
    for (long j = 0; j < n && isfinite(s[0]); j++) {
        double k[4][3], y[3];
        for (int i = 0; i < 4; i++) {
            double part = i == 0 ? 0 : i == 3 ? 1 : 0.5;
            for (int q = 0; q < 3; q++) y[q] = s[q] + (i ? part * d * k[i - 1][q] : 0);
            rates(m, r[FORCE] + m->now.slope * (j + part) * d, y, k[i]);
        }
        for (int q = 0; q < 3; q++) s[q] += d / 6 * (k[0][q] + 2 * k[1][q] + 2 * k[2][q] + k[3][q]);
    }
    if (!isfinite(s[0] + s[1] + s[2])) return 0;
    r[X] = s[0], r[V] = s[1];
    FILTERED(m) = s[2];
    r[FORCE] += m->now.slope * h;
    m->now.slope = 0;
    return 1;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    ENTER(STEP);
    CHECK(!(h <= 0), "no step");
    CHECK(isfinite(h), "no step");
    CHECK(t + h <= m->now.stop + 1e-9, "past the stop time");
    CHECK(h < 1e6, "too long a step");
    double size = h;
    if (size > 0 && !integrate(m, size)) {
        m->now.phase = FAILED;
        return tell(m, fmi2Discard, "the solution is lost");
    }
    m->now.t = t + h;
    return fmi2OK;
}
fmi2Status fmi2CancelStep(fmi2Component c) {
    ENTER(0);
    return fmi2OK;
}
#ifndef DEFECT_NO_EXPORT
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind k, fmi2Status *v) { return fmi2Discard; }
#endif
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    ENTER(STEP | FAILED | TERMINATED);
    *v = m->now.t;
    return k == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *v) { return fmi2Discard; }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) { return fmi2Discard; }
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *v) { return fmi2Discard; }

/* ---- no variables of these types ---- */
#define NONE(name, type) fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type v[]) { return n ? fmi2Error : fmi2OK; }
NONE(fmi2GetInteger, fmi2Integer)
NONE(fmi2GetBoolean, fmi2Boolean)
NONE(fmi2GetString, fmi2String)
NONE(fmi2SetInteger, const fmi2Integer)
NONE(fmi2SetBoolean, const fmi2Boolean)
NONE(fmi2SetString, const fmi2String)

/* ---- states ---- */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) {
    ENTER(ANY);
#ifdef DEFECT_NO_STATE
    return tell(m, fmi2Error, "not supported");
#endif
    if (!*s) *s = malloc(sizeof(Values));
    m->now.r[Z] = FILTERED(m);
#ifdef DEFECT_STATE_DISTURBS
    m->now.r[V] *= 1 + 1e-15;
#endif
    memcpy(*s, &m->now, sizeof(Values));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) {
    ENTER(ANY);
    double filtered = FILTERED(m);
    memcpy(&m->now, s, sizeof(Values));
    FILTERED(m) = m->now.r[Z];
#ifdef DEFECT_STATE_HIDDEN
    FILTERED(m) = filtered;
#endif
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) {
    free(*s);
    *s = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) {
    *n = sizeof(Values);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) {
    memcpy(b, s, sizeof(Values));
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) {
    ENTER(ANY);
    CHECK(n == sizeof(Values), "not a state of mine");
    *s = memcpy(malloc(n), b, n);
    return fmi2OK;
}

/* ---- model exchange ---- */
fmi2Status fmi2EnterEventMode(fmi2Component c) {
    ENTER(EVENT | CONTINUOUS);
    m->now.phase = EVENT;
    return fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    ENTER(EVENT);
    memset(info, 0, sizeof *info);
    return fmi2OK;
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    ENTER(EVENT);
    m->now.phase = CONTINUOUS;
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean final, fmi2Boolean *event, fmi2Boolean *end) {
    ENTER(CONTINUOUS);
    *event = *end = fmi2False;
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    ENTER(EVENT | CONTINUOUS);
    m->now.t = t;
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    ENTER(CONTINUOUS);
    CHECK(n == 3, "there are three states");
    m->now.r[X] = x[0], m->now.r[V] = x[1];
    FILTERED(m) = x[2];
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    x[0] = m->now.r[X], x[1] = m->now.r[V], x[2] = FILTERED(m);
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    update(m);
    dx[0] = m->now.r[V], dx[1] = m->now.r[A], dx[2] = m->now.r[RATE];
    for (int i = 0; i < 3; i++)
        if (!isfinite(dx[i])) return tell(m, fmi2Discard, "a rate is not finite");
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    for (size_t i = 0; i < n; i++) x[i] = 1;
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) { return n ? fmi2Error : fmi2OK; }
