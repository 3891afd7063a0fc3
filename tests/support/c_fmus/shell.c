/* An FMI 2.0 co-simulation FMU around a model of a few lines (MODEL, included below).
 *
 * The model defines N (number of Real variables, whose value references are 0 .. N-1), `start`
 * values, `update` (outputs from states and inputs; in initialization mode too) and `advance` (one
 * step; returns a status). Everything else of FMI answers "not supported", but is there, because
 * FMPy resolves all functions. STATE, INPUTS and JACOBIAN add what some FMUs can do: save and restore
 * their state (turn it into BYTES, too), follow inputs that are polynomials of time (`at`), tell directional derivatives.
 * LAZY makes it compute outputs in steps only, PICKY refuse values beyond 0.5 once it is initialised.
 * CONSTANT and OWN_STEP make it refuse steps of another size than its first, or than OWN_STEP.
 * CLEARS makes it lose all that can be read when anything is set after initialization, up to the end
 * of the next step, PARTLY but for what `partly` shows; NANS: what is lost is nan. ROUNDS makes it leave steps with rounding
 * upward. ARMED has it do harm: see trouble.h. FORGETS makes it leave its last variable as it is when it goes back. REFRESHES makes it compute outputs when something is set, and not after steps.
 */
#include <fenv.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "trouble.h"

typedef struct {
    double *r;      /* Real variables */
    double *d1, *d2; /* first and second time derivatives of inputs during a step */
    double t;       /* s */
    double stop;    /* s */
    double reached; /* s, the last successful time of a step that was discarded */
    int terminated; /* it asks for the end of the simulation: nothing may be set, no step be made */
    int stale;      /* outputs do not fit inputs and states */
    int running;    /* initialization mode or later */
    int started;    /* initialization is over */
    int initialised; /* later */
    double size;    /* s, of all steps, if it makes no other; 0 before it is known */
    double *shown;  /* what is read, if inputs that are set clear it (CLEARS) */
    fmi2ComponentEnvironment environment;
    fmi2CallbackLogger log;
    char name[64];
} Model;

#define SAY(m, status, ...) (m)->log((m)->environment, (m)->name, status, "logStatus", __VA_ARGS__)

/* Variable i, s after the start of a step. */
static double at(const Model *m, int i, double s) {
    return m->r[i] + s * m->d1[i] + s * s / 2 * m->d2[i];
}

typedef void (*Rates)(const Model *m, double s, const double *x, double *dx);

/* Runge-Kutta 4 in `pieces` substeps over h; s runs from 0 to h. */
static void rk4_in(const Model *m, int n, double *x, double h, int pieces, Rates f) {
    double k1[8], k2[8], k3[8], k4[8], y[8], d = h / pieces;
    for (int j = 0; j < pieces; j++) {
        double s = j * d;
        f(m, s, x, k1);
        for (int i = 0; i < n; i++) y[i] = x[i] + d / 2 * k1[i];
        f(m, s + d / 2, y, k2);
        for (int i = 0; i < n; i++) y[i] = x[i] + d / 2 * k2[i];
        f(m, s + d / 2, y, k3);
        for (int i = 0; i < n; i++) y[i] = x[i] + d * k3[i];
        f(m, s + d, y, k4);
        for (int i = 0; i < n; i++) x[i] += d / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
}
/* In 20 substeps: an error far below that of any coupling. */
static void rk4(const Model *m, int n, double *x, double h, Rates f) { rk4_in(m, n, x, h, 20, f); }

#include MODEL

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return fmi2OK; }

static void show(Model *m) {
    update(m);
    memcpy(m->shown, m->r, N * sizeof(double));
    m->started = 1;
}

#ifdef NANS
#define CLEARED NAN
#else
#define CLEARED 0
#endif

/* ONCE: one instance for each copy of the library. ALONE: one in the whole process. */
#ifdef ONCE
static int instances;
#endif
static int taken(void) {
#ifdef ALONE
    if (getenv("M4E_TEST_ALONE")) return 1;
    setenv("M4E_TEST_ALONE", "1", 1);
#endif
#ifdef ONCE
    if (instances++) return 1;
#endif
    return 0;
}
static void release(void) {
#ifdef ONCE
    instances--;
#endif
#ifdef ALONE
    unsetenv("M4E_TEST_ALONE");
#endif
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    if (taken()) return NULL;
    trouble("instantiate", INFINITY);
    Model *m = calloc(1, sizeof *m);
    m->r = malloc(sizeof start);
    memcpy(m->r, start, sizeof start);
    m->d1 = calloc(N, sizeof(double));
    m->d2 = calloc(N, sizeof(double));
    m->shown = calloc(N, sizeof(double));
#ifndef ANONYMOUS
    m->environment = functions->componentEnvironment;
#endif
    m->log = functions->logger;
    m->stale = 1;
    strncpy(m->name, name, sizeof m->name - 1);
    return m;
}

void fmi2FreeInstance(fmi2Component c) {
    Model *m = c;
    trouble("free", m->t);
    release();
    free(m->r);
    free(m->d1);
    free(m->d2);
    free(m->shown);
    free(m);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real t0, fmi2Boolean e, fmi2Real t1) { ((Model *)c)->t = t0; ((Model *)c)->stop = e ? t1 : INFINITY; return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { ((Model *)c)->running = 1; return fmi2OK; }
/* LOUD: says its name. ANONYMOUS: loses the environment, with which the importer tells instances. */
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    trouble("initialise", INFINITY);
    ((Model *)c)->initialised = 1;
    show(c);
#ifdef LOUD
    SAY((Model *)c, fmi2Warning, "here is %s", ((Model *)c)->name);
#endif
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    trouble("terminate", ((Model *)c)->t);
#ifdef RELUCTANT
    return fmi2Error;
#else
    return fmi2OK;
#endif
}
fmi2Status fmi2Reset(fmi2Component c) { memcpy(((Model *)c)->r, start, sizeof start); return fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    Model *m = c;
    if (m->initialised) trouble("get", m->t);
    if (m->stale && m->running) { update(m); m->stale = 0; }
    const double *r = m->r;
#ifdef CLEARS
    if (m->started) r = m->shown;
#endif
    for (size_t i = 0; i < n; i++) v[i] = r[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    Model *m = c;
    if (m->terminated) {
        SAY(m, fmi2Error, "nothing is set after the end");
        return fmi2Error;
    }
#ifdef PICKY
    for (size_t i = 0; i < n && m->running; i++)
        if (fabs(v[i]) > 0.5) return fmi2Error;
#endif
    if (m->initialised) trouble("set", m->t);
    for (size_t i = 0; i < n; i++) m->r[vr[i]] = v[i];
    for (int i = 0; i < N; i++) m->shown[i] = CLEARED;
#ifdef PARTLY
    partly(m);
#endif
#ifdef LAZY
    if (m->initialised) return fmi2OK;
#endif
    m->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_undo) {
    Model *m = c;
    if (m->terminated) {
        SAY(m, fmi2Error, "no step after the end");
        return fmi2Error;
    }
#ifdef STRICT
    if (t + h > m->stop) {
        SAY(m, fmi2Error, "Exceeded model finish time: %g > %g", t + h, m->stop);
        return fmi2Error;
    }
#endif
#ifdef CONSTANT
    if (!m->size) m->size = h;
#endif
#ifdef OWN_STEP
    m->size = OWN_STEP;
#endif
    if (m->size && h != m->size) {
        SAY(m, fmi2Error, "I make steps of %.17g s, not of %.17g s", m->size, h);
        return fmi2Error;
    }
    trouble("step", t);
    fmi2Status status = advance(m, t, h);
    for (int i = 0; i < N; i++) {
        if (m->d1[i] || m->d2[i]) m->r[i] = at(m, i, h);
        m->d1[i] = m->d2[i] = 0;
    }
    m->t = t + h;
#ifdef LAZY
    update(m);
#elif !defined REFRESHES
    m->stale = 1;
#endif
#ifdef CLEARS
    show(m);
#endif
#ifdef ROUNDS
    fesetround(FE_UPWARD);
#endif
    return status;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    *v = ((Model *)c)->reached;
    return k == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    *v = ((Model *)c)->terminated;
    return k == fmi2Terminated ? fmi2OK : fmi2Discard;
}

#define NOT_SUPPORTED(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2Error; }
NOT_SUPPORTED(fmi2GetInteger, fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer v[])
NOT_SUPPORTED(fmi2GetBoolean, fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean v[])
NOT_SUPPORTED(fmi2GetString, fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String v[])
NOT_SUPPORTED(fmi2SetInteger, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer v[])
NOT_SUPPORTED(fmi2SetBoolean, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean v[])
NOT_SUPPORTED(fmi2SetString, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String v[])
NOT_SUPPORTED(fmi2GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], fmi2Real v[])
NOT_SUPPORTED(fmi2CancelStep, fmi2Component c)
NOT_SUPPORTED(fmi2GetStatus, fmi2Component c, const fmi2StatusKind k, fmi2Status *v)
NOT_SUPPORTED(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind k, fmi2Integer *v)
NOT_SUPPORTED(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind k, fmi2String *v)

#ifdef BYTES
#define SIZE ((2 * N + 3) * sizeof(double))
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) {
    *n = SIZE;
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) {
    memcpy(b, s, SIZE);
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) {
    if (n != SIZE) return fmi2Error;
#ifdef UNREADABLE
    *(volatile int *)0 = 1;
#endif
    *s = malloc(SIZE);
    memcpy(*s, b, SIZE);
    return fmi2OK;
}
#else
NOT_SUPPORTED(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
NOT_SUPPORTED(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOT_SUPPORTED(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
#endif

#ifdef STATE
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) {
    Model *m = c;
    double *kept = *s ? *s : malloc((2 * N + 3) * sizeof(double));
    memcpy(kept, m->r, N * sizeof(double));
    kept[N] = m->t;
    kept[N + 1] = m->stale;
    memcpy(kept + N + 2, m->shown, N * sizeof(double));
    kept[2 * N + 2] = m->terminated;
    *s = kept;
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) {
    Model *m = c;
    double *kept = s;
#ifdef FORGETS
    kept[N - 1] = m->r[N - 1];
#endif
    memcpy(m->r, kept, N * sizeof(double));
    m->t = kept[N];
    m->stale = (int)kept[N + 1];
    memcpy(m->shown, kept + N + 2, N * sizeof(double));
    m->terminated = (int)kept[2 * N + 2];
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) {
    free(*s);
    *s = NULL;
    return fmi2OK;
}
#else
NOT_SUPPORTED(fmi2GetFMUstate, fmi2Component c, fmi2FMUstate *s)
NOT_SUPPORTED(fmi2SetFMUstate, fmi2Component c, fmi2FMUstate s)
NOT_SUPPORTED(fmi2FreeFMUstate, fmi2Component c, fmi2FMUstate *s)
#endif

#ifdef INPUTS
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], const fmi2Real v[]) {
    Model *m = c;
#ifdef SINGLE
    if (n > 1) return fmi2Error;
#endif
#ifdef LIMIT
    for (size_t i = 0; i < n; i++)
        if (o[i] > LIMIT) {
            SAY(m, fmi2Error, "derivative order %d is not supported", o[i]);
            return fmi2Error;
        }
#endif
#ifdef IGNORED
    for (size_t i = 0; i < n; i++)
        if (o[i] >= IGNORED) return fmi2Warning;
#endif
    for (size_t i = 0; i < n; i++) (o[i] == 1 ? m->d1 : m->d2)[vr[i]] = v[i];
    return fmi2OK;
}
#else
NOT_SUPPORTED(fmi2SetRealInputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], const fmi2Real v[])
#endif

#ifdef JACOBIAN
/* All models but those with products of variables are linear in their inputs: a difference is exact. */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[], size_t nv, const fmi2Real dv[], fmi2Real dz[]) {
    Model *m = c;
    double kept[N];
    update(m);
    memcpy(kept, m->r, sizeof kept);
    for (size_t i = 0; i < nv; i++) m->r[v[i]] += dv[i];
    update(m);
    for (size_t i = 0; i < nz; i++) dz[i] = m->r[z[i]] - kept[z[i]];
    memcpy(m->r, kept, sizeof kept);
    return fmi2OK;
}
#else
NOT_SUPPORTED(fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[], size_t nv, const fmi2Real dv[], fmi2Real dz[])
#endif
